"""What `Kept` is for `stickslip.studies.benchmark.records` is tested there; here is what it is by itself."""

import json

import pytest

from stickslip.common.kept import Kept


def test_results_come_back_by_name_and_nothing_else_does(tmp_path):
    kept = Kept(tmp_path / "run" / "cells", {"hold": 0.5})
    assert kept.load() == {}
    kept.keep("b", {"speed": 0.1 + 0.2})
    kept.keep("a", [1, None])
    (tmp_path / "run" / "cells" / ".c-1-2.json").write_text("half", encoding="utf-8")
    (tmp_path / "run" / "cells" / "note.txt").write_text("other", encoding="utf-8")
    again = Kept(tmp_path / "run" / "cells", {"hold": 0.5}, resume=True)
    assert list(again.load().items()) == [("a", [1, None]), ("b", {"speed": 0.1 + 0.2})]
    again.keep("a", 2)
    assert kept.load()["a"] == 2


def test_settings_may_grow_only_where_that_is_said(tmp_path):
    folder = tmp_path / "run" / "cells"
    Kept(folder, {"hold": 0.5, "named": {"a": 1}}).keep("x", 0)
    Kept(folder, {"hold": 0.5, "named": {"b": 2}}, resume=True, growing=["named"])
    settings = folder / "settings.json"
    assert json.loads(settings.read_text(encoding="utf-8")) == {"hold": 0.5, "named": {"a": 1, "b": 2}}
    settings.write_text('{"named": {"b": 2, "a": 1}, "hold": 0.5}', encoding="utf-8")
    Kept(folder, {"hold": 0.5, "named": {"a": 1}}, resume=True, growing=["named"])
    # Whoever adds nothing leaves what is written alone.
    assert settings.read_text(encoding="utf-8") == '{"named": {"b": 2, "a": 1}, "hold": 0.5}'
    with pytest.raises(ValueError, match=r"named\.a must be 1 to go on with the run in .*run, got 3"):
        Kept(folder, {"hold": 0.5, "named": {"a": 3}}, resume=True, growing=["named"])
    with pytest.raises(ValueError, match=r"named\.c must be absent .*; named\.a must be 1 to"):
        Kept(folder, {"hold": 0.5, "named": {"b": 2, "c": 3}}, resume=True)
    with pytest.raises(ValueError, match="run holds a run already: resume it, or choose another folder"):
        Kept(folder, {"hold": 0.5, "named": {"a": 1}}, growing=["named"])
