"""Type checkers and editors see what the package exports, in a development install as in a wheel."""

import json
import os
import shutil
import subprocess
import venv
from pathlib import Path

import mypy
import pytest
from checkout import FOLDERS, ROOT

import stickslip
import stickslip.crawler
import stickslip.reservoir
import stickslip.train

pytestmark = pytest.mark.xdist_group("typing")  # one installation of each kind is enough

INSTALLED = ("pyproject.toml", "README.md", "LICENSE", "src")
SUFFIXES = (".py", ".yml", ".jinja", ".json", ".safetensors", ".css", ".js", ".html", ".mplstyle")
HOW = {"development": ["--editable"], "wheel": []}

USER_CODE = """
from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import stickslip
from stickslip import Actuator, CrawlerReservoir, Groups, memory_capacity, Scene, simulate, Trajectory
from stickslip.reservoir import MemoryCapacity

assert_type(simulate(Groups(duffing=3.0), [1, 0], 1.0), Trajectory)
assert_type(simulate("linear", np.ones(3), 1.0, scene={"ratchet": False}).foot, NDArray[np.float64])
several = [Groups(), Groups(deborah=1)]
simulate(several, [1], 1.0, scene=Scene(anchored=True)).in_si(Actuator.ecoflex())
simulate([Groups(), "linear", {"duffing": 1.0}, Actuator.ecoflex()], [1], 1.0)
assert_type(Actuator.ecoflex().groups.to_dict(), dict[str, float])
assert_type(CrawlerReservoir("linear", hold=0.5).fit([0.1, 0.2]).transform([0.1]), NDArray[np.float64])
assert_type(memory_capacity(np.ones((50, 2)), np.ones(50), 5), MemoryCapacity)
assert_type(stickslip.simulate("linear", [1], 1.0), Trajectory)

Groups(dufing=3.0)  # wrong
Groups("soft")  # wrong
simulate(Groups(), [1, 0], 1.0, tolerence=1e-3)  # wrong
simulate(3.0, [1, 0], 1.0)  # wrong
simulate(Groups(), [1, 0], 1.0).foots  # wrong
CrawlerReservoir(holds=2)  # wrong
stickslip.simulte  # wrong
from stickslip import simulte  # wrong
"""

JEDI = """
import json, sys
import jedi

environment = jedi.create_environment(sys.prefix, safe=False)
found = {}
for code in json.load(sys.stdin):
    script = jedi.Script(code, environment=environment)
    found[code] = [[each.name for each in script.complete()], [each.to_string() for each in script.get_signatures()]]
print(json.dumps(found))
"""


HERE = """
import json, os
import stickslip
from stickslip import Groups
from stickslip.commands import app
from stickslip.train.algorithms import ALGORITHMS
from stickslip.train.hyperparameters import read_hyperparameters

found = os.path.dirname(stickslip.__file__)
walk = os.walk(found, followlinks=True)
files = [os.path.relpath(os.path.join(at, name), found) for at, _, names in walk for name in names]
print(json.dumps({
    "where": found,
    "files": files,
    "steps": [read_hyperparameters(name, "StickSlipCrawler-v0")["n_timesteps"] for name in ALGORITHMS],
    "groups": Groups(duffing=2.0).to_dict(),
    "opens": int(stickslip.pretrained("knee").predict([-1.0] + [0.0] * 7)),
}))
"""


def files_of_the_package():
    """What an installation must hold, relative to it: sources, and the data that they read."""
    for folder in FOLDERS:
        for at, _, names in os.walk(ROOT / folder):
            for file in (Path(at) / name for name in names if "__pycache__" not in at):
                if file.suffix in SUFFIXES or file.name == "py.typed":
                    yield str(file.relative_to(ROOT / folder if folder == "package" else ROOT))


def install(folder, how):
    """An environment of its own that holds a copy of the checkout's package, and reads all else from this one's."""
    source = folder / "checkout"
    source.mkdir()
    for name in (*INSTALLED, *FOLDERS):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        options = {"symlinks": True, "ignore": shutil.ignore_patterns("__pycache__", "*.egg-info")}
        copy(ROOT / name, source / name, **(options if copy is shutil.copytree else {}))
    venv.create(folder / "venv", with_pip=False)
    (site,) = (folder / "venv").glob("lib/python*/site-packages")
    (site / "others.pth").write_text(str(Path(mypy.__file__).parents[1]) + "\n", encoding="utf-8")
    python = folder / "venv" / "bin" / "python"
    pip = [python, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*pip, *HOW[how], str(source)], check=True, cwd=folder)
    return python, source


@pytest.fixture(scope="module", params=HOW)
def installed(request, tmp_path_factory):
    return install(tmp_path_factory.mktemp(request.param), request.param)


def type_check(python, folder, code):
    """Lines that mypy prints about a user's file; what it learns of other packages it keeps from run to run."""
    (folder / "user.py").write_text(code, encoding="utf-8")
    cache = ROOT / ".mypy_cache" / "users"
    cache.mkdir(parents=True, exist_ok=True)
    command = [python, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir", str(cache), "user.py"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode in (0, 1), done.stderr
    return done.stdout.splitlines()


def test_mypy_sees_the_real_types(installed, tmp_path):
    python, _ = installed
    lines = type_check(python, tmp_path, USER_CODE)
    wrong = [number for number, line in enumerate(USER_CODE.splitlines(), 1) if line.endswith("# wrong")]
    errors = [line for line in lines if ": error: " in line]
    assert [int(line.split(":")[1]) for line in errors] == wrong
    assert 'Unexpected keyword argument "dufing" for "Groups"' in errors[0]


def test_every_name_that_is_imported_on_first_use_has_a_type(installed, tmp_path):
    code, names = "", []
    for module in (stickslip, stickslip.crawler, stickslip.reservoir, stickslip.train):
        code += f"import {module.__name__}\n"
        names += [f"{module.__name__}.{name}" for name in module.__all__]
    lines = type_check(installed[0], tmp_path, code + "".join(f"reveal_type({name})\n" for name in names))
    revealed = [line for line in lines if ": note: Revealed type is " in line]
    assert len(revealed) == len(names)
    assert not [line for line in lines if ": error: " in line or line.endswith('"Any"')]


def test_an_editor_completes(installed, tmp_path):
    python, _ = installed
    expected = {
        "from stickslip import Groups\nGroups(duf": "duffing=",
        "from stickslip import simulate, Groups\nsimulate(Groups(), [1], 1.0).energy_": "energy_residual",
        "from stickslip import Actuator\nActuator.ecoflex().groups.damp": "damping_ratio",
        "from stickslip import CrawlerReservoir\nCrawlerReservoir().fit([1.0]).trans": "transform",
        "from stickslip import memory_capacity\nmemory_capacity([[1]], [1], 2).tot": "total",
        "import stickslip\nstickslip.simu": "simulate",
    }
    question = "from stickslip import Groups\nGroups("
    done = subprocess.run(
        [python, "-c", JEDI],
        input=json.dumps([*expected, question]),
        capture_output=True,
        text=True,
        cwd=tmp_path,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for code, name in expected.items():
        assert name in found[code][0], code
    assert found[question][1][0].startswith("Groups(duffing: float=0.5, damping_ratio: float=0.05")


def test_python_in_the_root_of_a_checkout_finds_the_whole_of_what_is_installed(installed):
    python, source = installed
    done = subprocess.run([python, "-c", HERE], capture_output=True, text=True, cwd=source, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    (site,) = python.parents[1].glob("lib/python*/site-packages")
    editable = any("editable" in path.name for path in site.iterdir())
    # Of an installed wheel nothing is read from the checkout that Python happens to be in.
    assert Path(found["where"]) == (source / "src" if editable else site) / "stickslip"
    expected = set(files_of_the_package())
    assert len(expected) > 130
    assert expected <= set(found["files"])
    assert {file for file in found["files"] if "__pycache__" not in file} == expected
    assert len(found["steps"]) >= 5
    assert found["groups"]["duffing"] == 2.0
    assert found["opens"] == stickslip.pretrained("knee").predict([-1.0] + [0.0] * 7)


def test_a_new_file_is_seen_at_once_in_a_development_install(tmp_path):
    python, source = install(tmp_path, "development")
    for folder, module in (("crawler", "stickslip.crawler.brand_new"), ("package", "stickslip.brand_new")):
        (source / folder / "brand_new.py").write_text("ANSWER: int = 42\n", encoding="utf-8")
        code = f"from {module} import ANSWER\nreveal_type(ANSWER)\n"
        assert type_check(python, tmp_path, code) == ['user.py:2: note: Revealed type is "int"']
        printed = subprocess.check_output([python, "-c", f"from {module} import ANSWER; print(ANSWER)"], cwd=tmp_path)
        assert int(printed) == 42
