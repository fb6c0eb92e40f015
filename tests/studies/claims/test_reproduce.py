"""C1, C2, and the folder that a reproduction leaves."""

import json

import numpy as np
import pytest
from legible import assert_legible
from matplotlib import pyplot as plt

from stickslip.commands import run
from stickslip.crawler import Actuator, Groups, Scene, simulate
from stickslip.studies.claims import crawl, twin
from stickslip.studies.claims import reproduce as reproduction
from stickslip.studies.claims.claim import CAPTIONS, Claim, CLAIMS, FIGURES, Number, UNKNOWN
from stickslip.studies.claims.page import sections
from stickslip.studies.claims.real_body import BODY, TUBE_MASS
from stickslip.studies.claims.reproduce import reproduce
from stickslip.studies.claims.sindy import nmse
from stickslip.studies.claims.twin_exact import exact_deformation
from stickslip.studies.claims.twin_figure import plot_twin
from stickslip.tasks import random_bits


def test_the_crawler_advances_in_every_cycle():
    motion = crawl.crawl()
    assert_legible(crawl.plot_crawl(motion))
    told = crawl.claim(motion)
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
    refined = np.full((2, len(twin.SEGMENTS) - 1, len(twin.MASSES), 2), 1e-5)
    converged = dict.fromkeys(twin.REGIMES, np.full((2, 2), 1e-6))
    return twin.Twin(lumped, refined, converged, 1e-14, dict.fromkeys(twin.SHARES, np.full((2, 2), 1e-3)))


def test_the_twins_verdict_follows_its_errors():
    good, bad = twin.claim(numbers_of(1e-3)), twin.claim(numbers_of(1e-2))
    assert (good.verdict, bad.verdict) == ("reproduced", "reproduced in part")
    assert "the tube lumped by a third at each end" in good.sentence
    assert "high damping: Pi2 = 0.5; aggressive forcing: Pi1 = 2, Pi5 = 0.4, static friction = 0.15" in good.remark
    assert good.numbers["z, error with half over that with a third, nominal"] == Number(pytest.approx(5.0))
    assert good.numbers["z, nominal, a third at each end, tube of 0.1"].value == pytest.approx(1.025e-2)
    assert good.numbers["foot, nominal, chain of 4 against 16, tube of 0.2"].value == 1e-5
    figure = plot_twin(numbers_of(1e-3))
    assert_legible(figure)
    assert [ax.get_title(loc="left") for ax in figure.axes] == [
        "One spring: z",
        "One spring: the foot",
        "Segments, nominal: z",
        "Segments, nominal: the foot",
    ]
    assert [text.get_text() for text in figure.axes[1].get_legend().get_texts()] == list(twin.REGIMES)


def test_which_lumping_is_better_is_said_where_the_interval_says_so():
    told, masses = numbers_of(1e-3), np.ones((2, len(twin.MASSES), 3))
    errors = [4.0, 5.0, 6.0], [0.1, 3.0, 6.0], [4.0, 4.0, 4.1], [0.2, 0.2, 0.3]
    for regime, half in zip(twin.REGIMES, errors, strict=True):
        told.lumped[regime, "half at each end"] = masses * half
        told.lumped[regime, "a third at each end"] = masses
    assert "for sure in 2 of 4 regimes (nominal, aggressive forcing), nominally by" in twin.claim(told).remark


@pytest.mark.parametrize(
    ("errors", "mass"),
    [
        ([1e-4, 2e-3, 4e-3, 8e-3, 9e-3], 0.5),
        ([2e-2, 3e-2, 4e-2, 5e-2, 6e-2], 0.0),
        ([1e-4, 1e-3, 1e-3, 4e-3, 4e-2], 0.2 * (0.5 / 0.2) ** (np.log(2.5) / np.log(10.0))),
    ],
)
def test_one_spring_is_good_up_to_where_its_error_passes_the_limit(errors, mass):
    assert twin.good_up_to(np.array(errors)) == pytest.approx(mass)


@pytest.mark.parametrize("segments", [1, 5])
def test_the_chain_is_that_of_its_exponential(segments):
    groups, valve = Groups(duffing=0.0, radial_coupling=0.0, damping_ratio=0.03, deborah=0.2), random_bits(12, 1)
    exact = exact_deformation(groups, valve, 0.7, 3, segments=segments, tube_mass=0.4)
    scene = Scene(segments=segments, tube_mass=0.4, anchored=True)
    told = simulate(groups, valve, 0.7, scene=scene, samples_per_hold=3, tolerance=1e-12).deformation
    np.testing.assert_allclose(told, exact, atol=1e-11)


def test_numbers_that_differ_in_their_last_words_alone_are_one_table():
    numbers = {f"{row}, {column}": Number(float(place)) for place, (row, column) in enumerate(TABLE)}
    page = sections([Claim("C1", "reproduced", "So.", numbers | {"alone": Number(7.0), "a, d": Number(8.0)})])
    assert "|  | x | y |\n|---|---:|---:|\n| b | 0 | 3 |\n| c | 1 | 4 |\n| e | 2 | 5 |" in page
    assert "| alone | 7 |\n| a, d | 8 |" in page
    few = sections([Claim("C1", "reproduced", "So.", dict(list(numbers.items())[:2]))])
    assert "| x, b | 0 |\n| x, c | 1 |" in few


TABLE = [("x", "b"), ("x", "c"), ("x", "e"), ("y", "b"), ("y", "c"), ("y", "e")]


def test_a_reproduction_leaves_claims_a_page_and_pictures(tmp_path, capsys):
    assert run(["reproduce", "fig1", "--quick", "--output", str(tmp_path)]) == 0
    assert "C1  reproduced" in capsys.readouterr().out
    (told,) = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert told["claim"] == CLAIMS["C1"]
    assert told["verdict"] == "reproduced"
    page = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert told["sentence"] in page
    assert "![fig1 of the paper, redone](fig1.png)" in page
    assert "Not drawn: what figS1 to figS5 show is not known" in page
    assert told["body"]["peak pressure"] == {"value": 20.0, "low": None, "high": None, "unit": "kPa"}
    picture = tmp_path / "fig1.png"
    assert picture.stat().st_size > 10_000

    written = picture.stat().st_mtime_ns
    assert run(["reproduce", "fig1", "--quick", "--output", str(tmp_path)]) == 0
    assert "done before" in capsys.readouterr().out
    assert picture.stat().st_mtime_ns == written
    picture.unlink()
    assert run(["reproduce", "fig1", "--quick", "--output", str(tmp_path)]) == 0
    assert picture.exists()
    assert run(["reproduce", "fig1", "--output", str(tmp_path)]) == 1
    assert "quick" in capsys.readouterr().err


def test_an_interrupted_reproduction_goes_on_where_it_was(tmp_path, monkeypatch):
    done = []

    def study(name, claim, *, fails=False):
        def measure(asked):
            if fails:
                raise KeyboardInterrupt
            done.append(name)

        return reproduction.Study(
            measure, lambda _: [Claim(claim, "reproduced", "So it is.")], {name: lambda _: figure()}
        )

    def figure():
        drawn, _ = plt.subplots()
        return drawn

    studies = {"one": study("fig1", "C1"), "two": study("figS6", "C2", fails=True)}
    monkeypatch.setattr(reproduction, "STUDIES", studies)
    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path)
    assert [claim["name"] for claim in json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))] == ["C1"]
    studies["two"] = study("figS6", "C2")
    assert [claim.name for claim in reproduce(tmp_path)] == ["C1", "C2"]
    assert done == ["fig1", "figS6"]
    assert [claim.name for claim in reproduce(tmp_path, ["figS6"])] == ["C1", "C2"]


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match="output must be a new folder or one of an earlier reproduction"):
        reproduce(tmp_path)
    with pytest.raises(ValueError, match="output must be a folder, got the file"):
        reproduce(tmp_path / "thesis.tex")
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize(
    ("kept", "said"), [('[{"name"', "crawl.json is no JSON: delete it"), ('[{"name": "C1"}]', "claims of another form")]
)
def test_a_folder_whose_claims_cannot_be_read_is_refused(tmp_path, monkeypatch, kept, said):
    monkeypatch.setattr(reproduction, "STUDIES", {})
    reproduce(tmp_path)
    (tmp_path / "studies" / "crawl.json").write_text(kept, encoding="utf-8")
    with pytest.raises(ValueError, match=said):
        reproduce(tmp_path)


def test_a_claim_is_the_same_once_it_was_kept():
    claim = Claim(
        "C1", "overturned", "No.", {"a": Number(1.0, 0.5, 1.5)}, "look", {"b": Number(2.0, unit="mm")}, "Also."
    )
    assert Claim.from_json(json.loads(json.dumps(claim.as_json()))) == claim


def test_an_actuator_can_bear_a_third_of_its_tube_at_each_end():
    measures = {"outer_radius": 0.01, "inner_radius": 0.006, "length": 0.11, "youngs_modulus": 7e4}
    rest = {"peak_pressure": 3e4, "lag": 0.02, "static_friction": 0.0, "kinetic_friction": 0.0, "damping": 0.3}
    masses = {"payload_mass": 0.14, "foot_mass": 0.06}
    bare, third = (
        Actuator.from_tube(**measures, **rest, **masses, density=density, tube_share=1.0 / 3.0)
        for density in (0.0, 1070.0)
    )
    tube = 1070.0 * np.pi * (0.01**2 - 0.006**2) * 0.11
    valve = random_bits(20, 0)
    told = twin._one_spring(bare.groups, tube / bare.mass, 1.0 / 3.0, valve)[0]
    hold = bare.scales.time / third.scales.time
    true = simulate(third.groups, valve, hold, samples_per_hold=20, tolerance=1e-8).deformation
    np.testing.assert_allclose(told, true, atol=1e-9)


def test_half_of_the_real_tube_at_each_end_is_the_real_body():
    valve = random_bits(20, 0)
    time = BODY.scales.time / np.sqrt(BODY.mass - TUBE_MASS) * np.sqrt(BODY.stiffness)
    true = simulate(BODY.groups, valve, 1.0 / time, samples_per_hold=20, tolerance=1e-8).deformation
    np.testing.assert_allclose(twin._one_spring(twin._bare(), twin._TUBE, 0.5, valve)[0], true, atol=1e-9)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["fig9"], "figures has no 'fig9'"),
        (["fig1", "figS3"], "figures cannot have 'figS3': what figS1 to figS5 show is not known: no claim names them"),
    ],
)
def test_a_figure_that_is_not_there_is_refused_before_anything_is_done(tmp_path, capsys, asked, said):
    with pytest.raises(ValueError, match=said):
        reproduce(tmp_path / "new", asked)
    assert run(["reproduce", *asked, "--output", str(tmp_path / "new")]) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_every_figure_of_the_paper_is_drawn_or_refused_with_the_reason():
    drawn = {figure for study in reproduction.STUDIES.values() for figure in study.figures}
    paper = {f"fig{number}" for number in range(1, 6)} | {f"figS{number}" for number in range(1, 11)}
    assert paper == (drawn - {"work"}) | set(UNKNOWN)
    assert not drawn & set(UNKNOWN)
    assert drawn == set(CAPTIONS)


@pytest.mark.parametrize("asked", [[], ["all"], ["claims"], ["fig1", "all"]])
def test_all_is_all_whatever_stands_beside_it(tmp_path, monkeypatch, capsys, asked):
    seen = []
    monkeypatch.setattr(reproduction, "reproduce", lambda folder, figures, **_: seen.append(figures) or [])
    assert run(["reproduce", *asked, "--output", str(tmp_path)]) == 0
    assert seen == [[]]
    assert "Not drawn: what figS1 to figS5 show is not known" in " ".join(capsys.readouterr().out.split())


def test_an_interrupted_command_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(reproduction, "reproduce", interrupted)
    assert run(["reproduce", "fig1", "--quick", "--output", str(tmp_path)]) == 130
    assert capsys.readouterr().err == f"interrupted; go on with: stickslip reproduce fig1 --quick --output {tmp_path}\n"


def test_every_claim_has_a_figure_that_a_study_draws():
    drawn = {figure for study in reproduction.STUDIES.values() for figure in study.figures}
    assert set(FIGURES) == set(CLAIMS)
    assert {figure for figures in FIGURES.values() for figure in figures} == drawn


def test_a_claim_is_one_of_the_paper():
    with pytest.raises(ValueError, match=r"name must be one of C1, .*got 'C99'"):
        Claim("C99", "reproduced", "")
    with pytest.raises(ValueError, match=r"verdict must be one of reproduced, .*got 'true'"):
        Claim("C1", "true", "")
    assert str(Number(0.5, 0.25, 0.75, "z_c")) == "0.5 [0.25, 0.75] z_c"
    assert str(Number(0.5)) == "0.5"
    assert str(Number(2646.4, -1024.0, 1.234e7)) == "2646 [-1024, 1.23e+07]"
