"""Output on terminals of every encoding, and text files in one."""

import ast
import io
import json
import os
import subprocess
import sys

import pytest
from checkout import FOLDERS, ROOT

from stickslip.commands import app, run
from stickslip.common.terminal import say_what_can_be_said, STAND_INS

WRITTEN = (*FOLDERS, "benchmarks", "docs")
WRITERS = {"write_text": 1, "read_text": 0, "open": 1, "loadtxt": None, "savetxt": None, "genfromtxt": None}
# All that makes Python guess UTF-8 switched off.
PLAIN = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": ""}


@pytest.fixture
def printed(monkeypatch):
    """Give commands a terminal of an encoding, and read what they print on it."""

    def terminal(encoding):
        streams = {name: io.TextIOWrapper(io.BytesIO(), encoding=encoding) for name in ("stdout", "stderr")}
        for name, stream in streams.items():
            monkeypatch.setattr(sys, name, stream)

        def read():
            for stream in streams.values():
                stream.flush()
            return [stream.buffer.getvalue().decode(encoding) for stream in streams.values()]

        return read

    return terminal


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_a_table_is_printed_on_any_terminal(printed, tmp_path, encoding):
    read = printed(encoding)
    command = ["speed", "--output", str(tmp_path / "speed"), "--groups", "linear", "--holds", "20", "--rounds", "2"]
    assert run(command) == 0
    out, _ = read()
    assert "closed_form" in out
    assert ("us per unit" if encoding == "ascii" else "µs per unit") in out
    assert "<=: at the floor" in out
    assert "?" not in out


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
@pytest.mark.parametrize("command", [[], *([each.name or each.callback.__name__] for each in app.registered_commands)])
def test_help_is_printed_on_any_terminal(printed, encoding, command):
    read = printed(encoding)
    assert run([*command, "--help"]) == 0
    assert read()[0].startswith("Usage: ")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_a_refusal_that_cannot_be_said_is_still_one_line(printed, tmp_path, encoding):
    read = printed(encoding)
    assert run(["speed", "--output", str(tmp_path), "--groups", "octøpus ± ☃ \udcff"]) == 1
    (line,) = read()[1].splitlines()
    assert line.startswith("error: groups must be one of the presets [")
    assert line.endswith("'oct?pus +- ? \\udcff'" if encoding == "ascii" else "'octøpus ± ? \\udcff'")


def test_every_sign_that_is_printed_has_a_stand_in():
    """Of all strings in the modules that commands print, docstrings apart."""
    signs = set()
    for file in (
        file for folder in ("package", "studies", "tasks", "common") for file in (ROOT / folder).rglob("*.py")
    ):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        docstrings = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
            and node.body
            and isinstance(node.body[0], ast.Expr)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
                signs |= {sign for sign in node.value if not sign.isascii()}
    assert "±" in signs
    assert signs <= set(STAND_INS)


def test_a_process_without_a_locale_trains_and_keeps_its_files_in_utf8(tmp_path):
    folder, file = tmp_path / "run", tmp_path / "propre.yml"
    entry = {"n_envs": 1, "n_timesteps": 100, "policy": "MlpPolicy", "n_steps": 50, "batch_size": 50}
    file.write_text("# à la main ±\n" + json.dumps({"StickSlipCrawler-v0": entry}), encoding="utf-8")
    arguments = ["train", "--output", str(folder), "--hyperparameters", str(file), "--dither", "0"]
    program = (
        "import sys, warnings; warnings.filterwarnings('error', category=EncodingWarning, module='stickslip')\n"
        "from stickslip.commands import run; sys.exit(run(sys.argv[1:]))"
    )
    command = [sys.executable, "-X", "warn_default_encoding", "-c", program, *arguments, "--memory-weight", "0"]
    done = subprocess.run(command, env={**os.environ, **PLAIN}, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert b"best policy: " in done.stdout
    for made in (folder / "configuration.yml", folder / "evaluations.csv"):
        made.read_bytes().decode("utf-8")
    evaluated = subprocess.run(
        [*command[:5], "evaluate", str(folder), "--steps", "1000", "--no-video"],
        env={**os.environ, **PLAIN},
        capture_output=True,
    )
    assert evaluated.returncode == 0, evaluated.stderr


def without_encoding(tree):
    """Calls that read or write text in whatever encoding the locale has."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        keywords = {keyword.arg for keyword in node.keywords}
        text = name in ("run", "check_output", "Popen") and keywords & {"text", "universal_newlines"}
        if name in WRITERS:
            positional = node.args[WRITERS[name] :] if WRITERS[name] is not None else []
            mode = "".join(str(ast.literal_eval(each)) for each in positional if isinstance(each, ast.Constant))
            opens_method = name == "open" and isinstance(node.func, ast.Attribute)
            text = not (name == "open" and (opens_method or "b" in mode))
            text = text and not (name in ("read_text", "write_text") and positional)
        if text and "encoding" not in keywords:
            yield node.lineno


def test_every_text_file_has_an_encoding():
    files = [file for folder in WRITTEN for file in (ROOT / folder).rglob("*.py")]
    assert len(files) > 100
    for file in files:
        assert not list(without_encoding(ast.parse(file.read_text(encoding="utf-8")))), file
    for bad in (
        "open('x')",
        "open('x', 'w')",
        "p.read_text()",
        "p.write_text(s)",
        "np.loadtxt(f)",
        "run(c, text=True)",
    ):
        assert list(without_encoding(ast.parse(bad))) == [1], bad
    for good in ("open('x', 'rb')", "p.read_text('utf-8')", "p.write_text(s, encoding='utf-8')", "run(c)"):
        assert not list(without_encoding(ast.parse(good))), good


def test_stand_ins_by_hand(printed):
    read = printed("ascii")
    say_what_can_be_said()
    print("±≤≥✗×µ–…↑↓ ☃ü", end="")
    print("a±b", file=sys.stderr, end="")
    assert read() == ["+-<=>=xxu-...^v ??", "a+-b"]


def test_what_cannot_be_decoded_stays_an_error():
    with pytest.raises(UnicodeDecodeError):
        b"\xff".decode("ascii", errors="stickslip.stand_ins")


def test_an_output_that_has_no_encoding_is_left_as_it_is(monkeypatch):
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    say_what_can_be_said()
    print("±", end="")
    assert sys.stdout.getvalue() == "±"
