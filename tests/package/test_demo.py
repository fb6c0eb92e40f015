"""The demo in small: every figure, number and policy it promises, each made again, and a page that shows them."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.commands import run
from stickslip.crawler import Groups, simulate
from stickslip.demo import tour
from stickslip.demo.page import write_page
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.reservoir import memory_capacity
from stickslip.studies.benchmark import Record, run_benchmark, STANDARD_RESERVOIRS, table
from stickslip.studies.trade.front import fronts
from stickslip.studies.trade.plan import Cell, FULL, LIMIT, QUICK, Trade, TRAINED
from stickslip.studies.trade.report import areas
from stickslip.studies.trade.report import table as table_of_front
from stickslip.studies.trade.running import TradeFolder
from stickslip.tasks import known_reservoirs, random_bits
from stickslip.train.evaluation import measure

SEED = 3
SMALL = {"weights": (0.0, 0.2), "longest": 3, "resolution": 6, "judges": 2, "holds": 1500, "conditioned": False}


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """A demo with a seed and steps of its own: what it printed, drew and filmed, and what is in its folder."""
    folder = tmp_path_factory.mktemp("demo") / "demo"
    figures, films, printed = {}, [], []
    with pytest.MonkeyPatch.context() as patch:
        save, film, console = tour.save_figure, tour.film, tour.Console
        patch.setattr(
            tour, "save_figure", lambda figure, file: (figures.update({file.name: figure}), save(figure, file))
        )
        patch.setattr(tour, "film", lambda *given, **named: (films.append((given, named)), film(*given, **named)))
        patch.setattr(tour, "_TRADE", SMALL)
        patch.setattr(tour, "processors", lambda: 1)

        def recording():
            printed.append(console(record=True, width=200))
            return printed[-1]

        patch.setattr(tour, "Console", recording)
        assert run(["demo", "--output", str(folder), "--steps", "600", "--seed", str(SEED)]) == 0
    return SimpleNamespace(
        folder=folder,
        figures=figures,
        films=films,
        printed=" ".join(printed[0].export_text().split()),
        page=(folder / "index.html").read_text(encoding="utf-8"),
        results=json.loads((folder / "results.json").read_text(encoding="utf-8")),
    )


@pytest.fixture(scope="module")
def trade(shown):
    """The trade that it has kept."""
    env_kwargs = {"hold": 0.5}
    asked = Trade(**SMALL, dithers=(0.0, 0.1), seeds=1, first_seed=SEED, steps=600, env_kwargs=env_kwargs)
    return TradeFolder(shown.folder / "trade", asked)


def lines(figure):
    return {line.get_label(): line.get_xydata() for ax in figure.axes for line in ax.lines}


def test_a_demo_of_the_usual_size_is_no_larger_than_a_quick_trade():
    usual = dict(tour._TRADE)
    weights, holds = usual.pop("weights"), usual.pop("holds")
    assert all(2 <= usual[name] <= QUICK[name] for name in usual)
    assert set(weights) < set(QUICK["weights"])
    assert {0.0, tour._MEMORY_WEIGHT} < set(weights)
    assert holds <= FULL["holds"]


def test_the_folder_holds_what_the_page_shows(shown):
    named = re.findall(r'src="([^"]+)"', shown.page)
    assert set(named) == {"trajectory.png", "memory.png", "trade.png", "learned.png", "gait.mp4"}
    assert all((shown.folder / name).stat().st_size > 1000 for name in named)
    assert {path.name for path in shown.folder.iterdir()} == {*named, "index.html", "results.json", "trade"}


def test_the_policies_are_those_of_the_seed_steps_and_rewards_asked_for(trade):
    trained = [cell for cell in trade.results() if cell.kind == TRAINED]
    assert [(cell.dither, cell.weight, cell.seed) for cell in trained] == [
        (0.0, 0.0, SEED),
        (0.1, 0.0, SEED),
        (0.1, 0.2, SEED),
    ]
    for cell in trained:
        policy = trade.policy(cell)
        assert policy.env_kwargs.items() >= {"dither": cell.dither, "memory_weight": cell.weight, "hold": 0.5}.items()
        algorithm = policy.description["algorithm"]
        assert (algorithm["name"], algorithm["seed"]) == ("ppo", SEED)
        assert algorithm["hyperparameters"]["n_timesteps"] == 600


def test_the_crawl_is_the_word_s_from_rest(shown):
    motion = simulate(Groups(), [1, 1, 1, 0, 0] * 8, 0.5, samples_per_hold=20)
    drawn = lines(shown.figures["trajectory.png"])
    np.testing.assert_array_equal(drawn["foot"][-800:, 1], motion.foot)
    np.testing.assert_array_equal(drawn["foot"][-800:, 0], motion.time)
    assert f"trajectory: {motion.foot[-1]:.1f} z_c in 20 t_c with {motion.slips} slips" in shown.printed
    said = " ".join(shown.page.split())
    assert "The word 11100, a hold of 0.5 t<sub>c</sub> each, from rest" in said
    assert f"{motion.foot[-1]:.1f} z<sub>c</sub> in 20 t<sub>c</sub> with {motion.slips} slips" in said


def test_memories_are_those_of_the_reservoirs_under_random_bits(shown):
    bits, known = random_bits(8000, SEED), known_reservoirs(hold=0.5)
    profiles = {name: memory_capacity(known[name](bits, SEED), bits, 20) for name in STANDARD_RESERVOIRS}
    assert shown.results["memory capacity"] == {name: each.corrected for name, each in profiles.items()}
    drawn = lines(shown.figures["memory.png"])
    for name, each in profiles.items():
        (curve,) = (values for label, values in drawn.items() if label.startswith(f"{name}: "))
        np.testing.assert_array_equal(curve[:, 1], each.profile)
    body = profiles["crawler"]
    assert f"<b>{body.corrected:.1f} of {body.bound}</b><span>past valve states" in shown.page
    assert 0 < shown.results["memory capacity"]["crawler"] < shown.results["memory capacity"]["delay line"]


def test_scores_are_those_of_five_seeds_and_stand_in_the_page(shown):
    records = [Record(**kept) for kept in shown.results["scores"]]
    assert {record.seed for record in records} == set(range(SEED, SEED + 5))
    known = known_reservoirs(hold=0.5)
    again = run_benchmark(reservoirs={"delay line": known["delay line"]}, seeds=[SEED + 4])
    scores = {record[:4] for record in records}
    assert len(again) >= 2
    assert {record[:4] for record in again} <= scores
    (one,) = run_benchmark(tasks=[again[0].task], reservoirs={"crawler": known["crawler"]}, seeds=[SEED + 1])
    assert one[:4] in scores
    for said in (shown.printed, shown.page):
        assert re.search(r"[Mm]ean \[95% interval of the mean\] over 5 seeds", said)
    rows = table(records)
    assert "NARMA-10 NRMSE ↓" in [row[0] for row in rows]
    for row in rows:
        assert_shown(row, shown)


def assert_shown(row, shown):
    """A row of a table stands in the page, and on the terminal."""
    cells = re.findall(r"<tr>(.*?)</tr>", re.sub("<sub>c</sub>", "_c", shown.page).replace("&nbsp;", " "))
    assert any(re.findall(r"<t[hd]>(.*?)</t[hd]>", each) == row for each in cells), row
    words = re.sub("[│┃ ]+", " ", shown.printed)
    assert " ".join(" ".join(row).split()) in words


def test_units_have_subscripts_in_tables_too(shown, tmp_path):
    assert not re.search(r"\b[zt]_c\b", shown.page)
    rows = [["speed (z_c/t_c) & <more> ↑"], ["1"]]
    profile, crawl = SimpleNamespace(corrected=1.0, bound=2), SimpleNamespace(foot=[1.0], time=[2.0], slips=3)
    content = dict.fromkeys(
        ("gain", "noiseless", "word", "dither", "weight", "hold", "judges", "holds", "elapsed"), 1.0
    )
    content |= {"limit": 1.0, "limit_noisy": 1.0, "seed": 0, "knee": None, "held_open": None, "crawl": crawl}
    content |= {"tasks": rows, "trade": rows, "areas": rows, "profiles": {"crawler": profile}}
    write_page(tmp_path / "index.html", **content)
    page = (tmp_path / "index.html").read_text("utf-8")
    assert page.count("<th>speed (z<sub>c</sub>/t<sub>c</sub>) &amp; &lt;more&gt;&nbsp;↑</th>") == 3


def test_the_trade_is_that_of_its_folder(shown, trade):
    quiet, front = fronts(trade.trade, trade.results())
    assert shown.results["trade"] == json.loads(json.dumps({"0.0": quiet.summary(), "0.1": front.summary()}))
    for row in (*table_of_front(front), *areas(front)):
        assert_shown(row, shown)
    assert "speed against memory, dither 0.1, mean [95% interval] over 2 seeds" in shown.printed
    drawn = lines(shown.figures["trade.png"])
    assert drawn["one policy a weight"].tolist() == [list(policy.mean) for policy in front.policies]
    assert len(shown.figures["learned.png"].axes) == 4


def test_the_learned_gait_is_measured_and_filmed_without_flips(shown, trade):
    gait = trade.policy(Cell(TRAINED, 0.0, 0.0, SEED))
    quiet = StickSlipCrawlerEnv(**gait.env_kwargs)
    speed = measure(gait, quiet, steps=SMALL["holds"], seed=SEED)[0].speed
    limit = np.mean(trade.results()[Cell(LIMIT, 0.0)]["speeds"])
    assert f"reaches: {speed:.3f} z<sub>c</sub>/t<sub>c</sub></span>" in shown.page
    assert f"<b>{100 * speed / limit:.1f}%</b><span>of the fastest crawl that is possible" in shown.page
    assert (
        f"speed policy without dither: {speed:.4f} z_c/t_c, {speed / limit:.1%} of the limit ({limit:.4f})"
    ) in shown.printed
    (((policy, file), named),) = shown.films
    assert file == shown.folder / "gait.mp4"
    assert named == {"env_kwargs": gait.env_kwargs, "seed": SEED}
    assert policy.description == gait.description


def test_how_long_it_took_and_the_seed_are_told(shown):
    assert shown.results["seed"] == SEED
    took = f"{shown.results['seconds']:.0f} s"
    assert f"All on this page took {took}, seed {SEED}." in shown.page
    assert f"all of it in {took}: open {shown.folder / 'index.html'}" in shown.printed


def test_a_demo_of_other_steps_takes_the_place_of_an_earlier_trade(tmp_path):
    (tmp_path / "cells").mkdir()
    for name, text in (("settings.json", '{"holds": 7}'), ("open-loop-dither-0.1.json", "{}")):
        (tmp_path / "cells" / name).write_text(text, encoding="utf-8")
    asked = Trade(**SMALL)
    assert tour._folder(tmp_path, asked).results() == {}
    (tmp_path / "policies" / "kept").touch()
    tour._folder(tmp_path, asked)
    assert (tmp_path / "policies" / "kept").exists()
