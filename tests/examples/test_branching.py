import re
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "branching.py"


def test_a_planner_over_a_thousand_branches_earns_more_than_a_schedule():
    command = [sys.executable, str(EXAMPLE), "--steps", "60"]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    planned, periodic = (float(number) for number in re.findall(r"(?:planned|11100) (-?[\d.]+)", said))
    assert planned > periodic > 0
