"""`stickslip compile` leaves nothing to compile."""

import os
import subprocess
import sys

import pytest

AGAIN = """
import stickslip.ahead
for _, use in stickslip.ahead.uses():
    use()
"""


@pytest.mark.slow
def test_after_it_nothing_is_compiled(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", "from stickslip.cli import main; main()", "compile"]
    first = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=1800)
    assert first.returncode == 0, first.stderr
    assert f"kept in {tmp_path}" in first.stdout
    kept = {file: file.read_bytes() for file in tmp_path.rglob("*.nbc")}
    assert len(kept) > 100
    # Neither by a second call nor by use in another process.
    for again in (command, [sys.executable, "-c", AGAIN]):
        done = subprocess.run(again, env=environment, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        assert "compiling kernels" not in done.stderr
    assert {file: file.read_bytes() for file in tmp_path.rglob("*.nbc")} == kept


def test_where_nothing_can_be_kept_it_is_refused(tmp_path):
    (tmp_path / "file").touch()
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "file")}
    done = subprocess.run(
        [sys.executable, "-c", "from stickslip.cli import main; main()", "compile"],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 1
    assert done.stderr.strip().endswith("set NUMBA_CACHE_DIR to one that can")
