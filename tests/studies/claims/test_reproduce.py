"""C1, C2, and the folder that a reproduction leaves."""

import json

import numpy as np
import pytest

from stickslip.commands import run
from stickslip.crawler import Groups, Scene, simulate
from stickslip.studies.claims import crawl, twin
from stickslip.studies.claims.claim import Claim, CLAIMS, Number
from stickslip.studies.claims.reproduce import reproduce
from stickslip.studies.claims.sindy import nmse
from stickslip.studies.claims.twin_figure import plot_twin
from stickslip.tasks import random_bits


def test_the_crawler_advances_in_every_cycle():
    told = crawl.claim(crawl.crawl())
    assert told.verdict == "reproduced"
    way = told.numbers["way of the foot in a cycle, least and greatest"]
    assert 1.2 < way.low <= way.value <= way.high < 1.3
    glued = crawl.claim(crawl.crawl(Groups(static_friction=5.0)))
    assert glued.verdict == "not reproduced"


def test_a_third_of_the_tube_at_each_end_is_better_than_half():
    valve = random_bits(30, 0)
    true = twin._chain(Groups(), 0.1, 4, valve)
    half, third = (nmse(twin._one_spring(Groups(), 0.1, share, valve)[0], true[0]) for share in (0.5, 1.0 / 3.0))
    assert third < 0.5 * half < 0.05


def test_half_of_the_tube_at_each_end_is_the_scene_of_one_heavy_segment():
    valve = random_bits(30, 0)
    scene = Scene(segments=1, tube_mass=0.3)
    motion = simulate(Groups(), valve, 1.0, scene=scene, samples_per_hold=20, tolerance=1e-8)
    np.testing.assert_allclose(twin._one_spring(Groups(), 0.3, 0.5, valve)[0], motion.deformation, atol=1e-9)


def numbers_of(error):
    shape = 2, len(twin.MASSES), 2
    slope = np.linspace(0.5, 20.0, len(twin.MASSES))[:, np.newaxis]
    lumped = {
        (regime, share): error * slope * (1.0 if part < 0.5 else 5.0) * np.ones(shape)
        for regime in twin.REGIMES
        for share, part in twin.SHARES.items()
    }
    return twin.Twin(lumped, np.full((2, len(twin.SEGMENTS) - 1, 2), 1e-5))


def test_the_twins_verdict_follows_its_errors():
    good, bad = twin.claim(numbers_of(1e-3)), twin.claim(numbers_of(1e-2))
    assert (good.verdict, bad.verdict) == ("reproduced", "reproduced in part")
    assert "lumped with a third at each end" in good.sentence
    assert "5.0 times less than with half" in good.sentence
    figure = plot_twin(numbers_of(1e-3))
    assert figure.axes[0].get_ylabel() == "NMSE of z"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(twin.REGIMES)


def test_a_reproduction_leaves_claims_a_page_and_pictures(tmp_path, capsys):
    assert run(["reproduce", "fig1", "--quick", "--output", str(tmp_path)]) == 0
    assert "C1  reproduced" in capsys.readouterr().out
    (told,) = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert told["claim"] == CLAIMS["C1"]
    assert told["verdict"] == "reproduced"
    page = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert told["sentence"] in page
    assert "![fig1 of the paper, redone](fig1.png)" in page
    assert (tmp_path / "fig1.png").stat().st_size > 10_000


def test_a_figure_that_is_not_there_is_refused(tmp_path, capsys):
    with pytest.raises(ValueError, match="figures"):
        reproduce(tmp_path, ["fig9"])
    assert run(["reproduce", "fig9", "--output", str(tmp_path)]) == 1
    assert "fig9" in capsys.readouterr().err


def test_a_claim_is_one_of_the_paper():
    with pytest.raises(ValueError, match=r"name must be one of C1, .*got 'C99'"):
        Claim("C99", "reproduced", "")
    with pytest.raises(ValueError, match=r"verdict must be one of reproduced, .*got 'true'"):
        Claim("C1", "true", "")
    assert str(Number(0.5, 0.25, 0.75, "z_c")) == "0.5 [0.25, 0.75] z_c"
    assert str(Number(0.5)) == "0.5"
