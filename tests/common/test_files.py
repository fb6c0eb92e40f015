"""Files written whole or not at all."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from stickslip.common.files import atomically


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old", encoding="utf-8")
    return path


@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()])
def test_a_file_is_written_whole_or_not_at_all(file, failure):
    def fail(path):
        path.write_text("half", encoding="utf-8")
        raise failure

    with pytest.raises(type(failure)):
        atomically(file, fail)
    assert file.read_text(encoding="utf-8") == "old"
    assert list(file.parent.iterdir()) == [file]


def test_a_failure_between_writing_and_renaming_leaves_the_old_file_alone(file, monkeypatch):
    def no_renaming(self, target):
        assert self.read_text(encoding="utf-8") == "new"
        raise PermissionError("in use")

    monkeypatch.setattr(Path, "replace", no_renaming)
    with pytest.raises(PermissionError, match="in use"):
        atomically(file, lambda path: path.write_text("new", encoding="utf-8"))
    assert file.read_text(encoding="utf-8") == "old"
    assert list(file.parent.iterdir()) == [file]


def test_a_process_that_ends_while_it_writes_leaves_the_old_file_and_the_next_writer_alone(file):
    program = (
        "import os, sys; from pathlib import Path; from stickslip.common.files import atomically\n"
        "atomically(Path(sys.argv[1]), lambda path: (path.write_text('half', encoding='utf-8'), os._exit(9)))"
    )
    assert subprocess.run([sys.executable, "-c", program, str(file)]).returncode == 9
    assert file.read_text(encoding="utf-8") == "old"
    atomically(file, lambda path: path.write_text("new", encoding="utf-8"))
    assert file.read_text(encoding="utf-8") == "new"


def test_what_is_unfinished_stands_beside_the_file_with_its_suffix(file):
    seen = []

    def write(path):
        seen.append(path)
        assert file.read_text(encoding="utf-8") == "old"
        path.write_text("new", encoding="utf-8")

    atomically(file, write)
    (path,) = seen
    assert (path.parent, path.suffix) == (file.parent, ".txt")
    assert path.name.startswith(".file-")
    assert str(os.getpid()) in path.name
    assert file.read_text(encoding="utf-8") == "new"
    assert list(file.parent.iterdir()) == [file]


def test_two_threads_that_write_one_file_write_it_whole(file):
    """The first has written half of it when the second begins, and ends only when the second has ended."""
    half_written, other_done = threading.Event(), threading.Event()

    def slowly(path):
        with path.open("w", encoding="utf-8") as stream:
            stream.write("first ")
            stream.flush()
            half_written.set()
            assert other_done.wait(10)
            stream.write("whole")

    first = threading.Thread(target=atomically, args=(file, slowly))
    first.start()
    assert half_written.wait(10)
    atomically(file, lambda path: path.write_text("second", encoding="utf-8"))
    assert file.read_text(encoding="utf-8") == "second"
    other_done.set()
    first.join()
    assert file.read_text(encoding="utf-8") == "first whole"
    assert list(file.parent.iterdir()) == [file]
