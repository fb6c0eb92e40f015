"""The page of claims: what is renewed, and what stays."""

import json

import claims as script
import pytest

from stickslip.studies.claims.claim import Claim, Number


def claim(name, sentence):
    return Claim(name, "reproduced", sentence, {"a": Number(1.0)}, "look")


@pytest.fixture
def page(tmp_path, monkeypatch):
    """A page that holds C1 and C10, and a folder in which both come out otherwise."""
    for name, file in {"RESULTS": "claims.json", "PAGE": "claims.md", "IMAGES": "images"}.items():
        monkeypatch.setattr(script, name, tmp_path / file)
    (tmp_path / "images").mkdir()
    kept = [claim(name, "Old.").as_json() for name in ("C1", "C10")]
    script.RESULTS.write_text(json.dumps({"quick": False, "claims": kept}), encoding="utf-8")
    marks = "".join(f"<!-- {name} -->\n<!-- end -->\n" for name in ("command", "claims"))
    script.PAGE.write_text(marks, encoding="utf-8")

    def reproduce(folder, figures, **_):
        for name in ("fig1", "work"):
            (folder / f"{name}.png").write_text(name, encoding="utf-8")
        return [claim("C1", "New."), claim("C10", "New.")]

    monkeypatch.setattr(script, "reproduce", reproduce)

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["claims.py", *arguments, "--folder", str(tmp_path)])
        script.main()
        return {
            each["name"]: each["sentence"] for each in json.loads(script.RESULTS.read_text(encoding="utf-8"))["claims"]
        }

    return run


def test_all_claims_are_renewed_by_default(page):
    assert page() == {"C1": "New.", "C10": "New."}
    assert {image.name for image in script.IMAGES.iterdir()} == {"claims_fig1.png", "claims_work.png"}
    assert "Old." not in script.PAGE.read_text(encoding="utf-8")


def test_claims_of_other_figures_stay_as_they_were(page):
    assert page("work") == {"C1": "Old.", "C10": "New."}
    assert [image.name for image in script.IMAGES.iterdir()] == ["claims_work.png"]
    text = script.PAGE.read_text(encoding="utf-8")
    assert "Old." in text
    assert "New." in text


def test_a_quick_run_renews_no_claim_of_a_full_one(page):
    with pytest.raises(ValueError, match="same size only, got quick = True"):
        page("work", "--quick")
