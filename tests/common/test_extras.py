"""What only an extra installs is imported where it is needed, and missed by the extra's name."""

import ast
import importlib
import re
import subprocess
import sys
import tomllib

import pytest
from checkout import FOLDERS, ROOT
from gymnasium.error import DependencyNotInstalled

from stickslip.common.extras import EXTRAS, MissingExtra, optional_import

WRITTEN = (*FOLDERS, "benchmarks", "docs")
EXTRA_OF = {package: extra for extra, packages in EXTRAS.items() for package in packages}
# Where a package is not imported by the name it is installed by.
DISTRIBUTIONS = {"PIL": "pillow", "yaml": "pyyaml"}


def message(package):
    extra = re.escape(f"[{EXTRA_OF[package]}]")
    return rf'^{package} is not installed: run `pip install "stickslip{extra}"`, or `pip install "\.{extra}"` in'


def test_the_extras_are_those_of_the_project():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for extra, requirements in extras.items():
        if extra not in ("dev", "docs"):  # of who works on the package
            named = [re.match(r"[\w-]+", requirement)[0].replace("-", "_") for requirement in requirements]
            installed = {DISTRIBUTIONS.get(package, package) for package in EXTRAS[extra]}
            # What a smaller extra installs as well is named by that one.
            smaller = {DISTRIBUTIONS.get(each, each) for other in EXTRAS if other != extra for each in EXTRAS[other]}
            assert {each for each in named if each not in smaller | {"stickslip"}} == installed, extra


@pytest.mark.parametrize("package", sorted(EXTRA_OF))
def test_a_missing_package_is_named_with_its_extra(monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    for kind in (ModuleNotFoundError, DependencyNotInstalled, MissingExtra):
        with pytest.raises(kind, match=message(package)), optional_import():
            importlib.import_module(package)
    with pytest.raises(MissingExtra, match=message(package)), optional_import():
        importlib.import_module(f"{package}.part")


def test_what_is_no_extra_is_missed_as_ever():
    with pytest.raises(ModuleNotFoundError, match="No module named 'octopus'") as caught, optional_import():
        importlib.import_module("octopus")
    assert not isinstance(caught.value, MissingExtra)


def unguarded(tree):
    """Imports of extras that are neither for type checkers nor inside ``with optional_import()``."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.With) and ast.unparse(node.items[0]) == "optional_import()":
            continue
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [] if node.level else [node.module]
        else:
            names = []
        yield from (name for name in names if name.partition(".")[0] in EXTRA_OF)
        yield from unguarded(node)


def test_every_import_of_an_extra_is_guarded():
    files = [file for folder in WRITTEN for file in (ROOT / folder).rglob("*.py")]
    files = [file for file in files if file.parent.name != "tutorials"]  # which say at their begin what they need
    assert len(files) > 80
    for file in files:
        assert not list(unguarded(ast.parse(file.read_text(encoding="utf-8")))), file
    assert list(unguarded(ast.parse("def f():\n    import torch.nn"))) == ["torch.nn"]


def without(package, code):
    """What a process that cannot import a package says of a program."""
    program = f"import sys; sys.modules[{package!r}] = None; {code}"
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, encoding="utf-8")


@pytest.mark.parametrize("package", ["typer", "rich"])
def test_the_command_line_names_its_extra(package):
    done = without(package, "from stickslip.cli import main; main()")
    assert done.returncode == 1
    assert done.stdout == ""
    assert re.fullmatch(message(package)[1:] + " a checkout", done.stderr.strip().removeprefix("error: "))


@pytest.mark.parametrize("package", ["tensorboard", "torch", "yaml"])
def test_training_names_its_extra(package, tmp_path):
    code = f"from stickslip.commands import run; sys.exit(run(['train', '--output', {str(tmp_path / 'run')!r}]))"
    done = without(package, code)
    assert done.returncode == 1
    assert re.match(message(package)[1:], done.stderr.strip().removeprefix("error: "))
    assert not (tmp_path / "run").exists()


def test_a_figure_names_its_extra():
    done = without("matplotlib", "from stickslip import simulate; simulate('linear', [1], 1.0).plot()")
    assert re.match(message("matplotlib")[1:], done.stderr.splitlines()[-1].partition(": ")[2])


def test_a_film_names_its_extra(monkeypatch, tmp_path):
    from stickslip.train.evaluation import film

    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtra, match=message("imageio_ffmpeg")):
        film(None, tmp_path / "clip.mp4", env_kwargs={})
    assert list(tmp_path.iterdir()) == []


def test_a_benchmark_leaves_out_a_peer_that_is_missing(monkeypatch, capsys):
    peers = importlib.import_module("peers")
    monkeypatch.setattr(peers, "SOLVERS", {"with_heyoka": "heyoka"})
    monkeypatch.setitem(sys.modules, "heyoka", None)
    monkeypatch.delitem(sys.modules, "peer_solvers.with_heyoka", raising=False)
    assert list(peers.available()) == []
    line = capsys.readouterr().out.strip()
    assert re.match(message("heyoka")[1:], line.removeprefix("heyoka is left out: "))
