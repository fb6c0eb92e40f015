"""The demo in small: every figure, number and policy it promises, each made again, and a page that shows them."""

import json
import re
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.commands import run
from stickslip.crawler import Groups, Scene, simulate
from stickslip.demo import tour
from stickslip.demo.classroom import Classroom, Lesson
from stickslip.envs import StickSlipCrawlerEnv
from stickslip.reservoir import memory_capacity
from stickslip.studies.benchmark import Record, run_benchmark, STANDARD_RESERVOIRS, table
from stickslip.tasks import known_reservoirs, random_bits
from stickslip.train import verdict
from stickslip.train.evaluation import measure
from stickslip.train.run import Configuration, Run
from stickslip.train.schedules import necklaces, performance, repeat
from stickslip.train.training import load_policy

SEED = 3
NOISY = {"memory_weight": 0.5, "dither": 0.1, "valve_history": 4}
QUIET = {"memory_weight": 0.0, "dither": 0.0, "valve_history": 4}


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

        def recording():
            printed.append(console(record=True, width=200))
            return printed[-1]

        patch.setattr(tour, "Console", recording)
        patch.setattr(tour, "Classroom", partial(Classroom, judging=verdict.STANDARD))
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
def measured(shown):
    """Its policies measured again, by the names that it shows."""
    names = {"speed": "speed policy", "memory": "memory_weight = 0.5 policy"}
    policies = {folder: load_policy(Run.open(shown.folder / "policies" / folder), trust=True) for folder in names}
    return {
        name: measure(policies[folder], StickSlipCrawlerEnv(**NOISY), steps=6000, seed=SEED)[0]
        for folder, name in names.items()
    } | {"quiet": measure(policies["speed"], StickSlipCrawlerEnv(**QUIET), steps=2000, seed=SEED)[0]}


def open_loop(word, dither=0.1):
    command, valve = repeat(word, 6000, dither=dither, seed=SEED)
    return performance(command, valve, dither=dither, groups=Groups(), hold=0.5, scene=Scene(), delays=20)


def lines(figure):
    return {line.get_label(): line.get_xydata() for ax in figure.axes for line in ax.lines}


def test_the_folder_holds_what_the_page_shows(shown):
    named = re.findall(r'src="([^"]+)"', shown.page)
    assert set(named) == {"trajectory.png", "memory.png", "trade.png", "gait.mp4"}
    assert all((shown.folder / name).stat().st_size > 1000 for name in named)
    assert {path.name for path in shown.folder.iterdir()} == {*named, "index.html", "results.json", "policies"}
    assert {path.name for path in (shown.folder / "policies").iterdir()} == {"speed", "memory"}


def test_the_policies_are_those_of_the_seed_steps_and_rewards_asked_for(shown):
    for name, arguments in (("speed", QUIET), ("memory", NOISY)):
        kept = Run.open(shown.folder / "policies" / name).configuration
        assert (kept.algorithm, kept.seed, kept.hyperparameters["n_timesteps"]) == ("ppo", SEED, 600)
        assert kept.env_kwargs == arguments


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
    assert f"<b>{body.corrected:.2f}</b>" in shown.page
    assert f"of {body.bound} possible" in shown.page
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
    cells = re.findall(r"<tr>(.*?)</tr>", shown.page)
    assert any(re.findall(r"<t[hd]>(.*?)</t[hd]>", each) == row for each in cells), row
    words = re.sub("[│┃ ]+", " ", shown.printed)
    assert " ".join(" ".join(row).split()) in words


def test_the_trade_is_that_of_every_schedule_and_both_policies(shown, measured):
    found = shown.results["open loop"]
    assert list(found) == list(necklaces(7))
    for word in ("1", "0", "11100", "1100100"):
        again = open_loop(word)
        assert found[word] == {
            "speed": again.speed,
            "memory capacity": again.memory.corrected,
            "raw": again.memory.total,
        }
    policies = ("speed policy", "memory_weight = 0.5 policy")
    assert shown.results["policies"] == {
        name: {
            "speed": measured[name].speed,
            "memory capacity": measured[name].memory.corrected,
            "raw": measured[name].memory.total,
        }
        for name in policies
    }
    drawn = lines(shown.figures["trade.png"])
    points = [[each["speed"], each["memory capacity"]] for each in found.values()]
    assert drawn["open-loop schedules"].tolist() == points
    for name in policies:
        assert drawn[name].tolist() == [[measured[name].speed, measured[name].memory.corrected]]
    fastest = max(found, key=lambda word: found[word]["speed"])
    rows = {f"open loop {fastest}": found[fastest], "valve held open": found["1"], **shown.results["policies"]}
    assert_shown(["schedule", "speed (z_c/t_c)", "memory capacity"], shown)
    for name, numbers in rows.items():
        assert_shown([name, f"{numbers['speed']:.3f}", f"{numbers['memory capacity']:.2f}"], shown)
    assert "speed against memory, dither 0.1" in shown.printed


def test_the_learned_gait_is_measured_and_filmed_without_flips(shown, measured):
    speed, best = measured["quiet"].speed, open_loop("11100", dither=0.0).speed
    assert shown.results["speed policy without dither"] == speed
    assert shown.results["word 11100 without dither"] == best > 1.05
    assert f"<b>{speed:.3f} z<sub>c</sub>/t<sub>c</sub></b>" in shown.page
    assert f"{100 * speed / best:.1f}% of the best open-loop schedule, 11100" in shown.page
    assert (
        f"speed policy without dither: {speed:.4f} z_c/t_c, {speed / best:.1%} of the open-loop word 11100 ({best:.4f})"
    ) in shown.printed
    (((policy, file), named),) = shown.films
    assert file == shown.folder / "gait.mp4"
    assert named == {"env_kwargs": QUIET, "seed": SEED}
    again = measure(policy, StickSlipCrawlerEnv(**QUIET), steps=2000, seed=SEED)[0]
    assert again.speed == speed


def test_how_long_it_took_and_the_seed_are_told(shown):
    assert shown.results["seed"] == SEED
    took = f"{shown.results['seconds']:.0f} s"
    assert f"<b>{took}</b><span>for all on this page, seed {SEED}</span>" in shown.page
    assert f"all of it in {took}: open {shown.folder / 'index.html'}" in shown.printed


LESSONS = (Lesson("one", "one", QUIET), Lesson("other", "other", {**QUIET, "hold": 0.75}))
SMALL = {"n_envs": 2, "n_steps": 4, "batch_size": 8, "policy": "MlpPolicy", "n_timesteps": 8}


def test_a_classroom_trains_each_lesson_and_says_how_far_it_is(tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip.demo.classroom.read_hyperparameters", lambda *_: dict(SMALL))
    console = tour.Console(record=True, width=100)
    # What an interrupted demo left unfinished is gone on with; what was finished, or of other steps, is made anew.
    for folder, steps in (("one", 8), ("other", 99)):
        asked = Configuration(
            env_kwargs=dict(zip(("one", "other"), (each.env_kwargs for each in LESSONS), strict=True))[folder],
            hyperparameters=SMALL | {"n_timesteps": steps},
            seed=SEED,
        )
        Run.create(tmp_path / folder, asked)
        (tmp_path / folder / "note").touch()
    with Classroom(tmp_path, LESSONS, SEED, None, verdict.STANDARD) as classroom:
        classroom.show(console)
    shown = console.export_text()
    for lesson, kept in zip(LESSONS, (True, False), strict=True):
        run = classroom.run(lesson)
        assert run.folder == tmp_path / lesson.folder
        assert run.configuration == Configuration(env_kwargs=lesson.env_kwargs, hyperparameters=SMALL, seed=SEED)
        assert load_policy(run, run.final, trust=True).num_timesteps == 8
        assert (run.folder / "note").exists() == kept
        assert re.search(rf"training {lesson.name} +━{{40}} ", shown)


def test_a_lesson_that_fails_ends_the_classroom(tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip.demo.classroom.read_hyperparameters", lambda *_: dict(SMALL))
    (tmp_path / "one").touch()  # a file where the folder is to be
    with Classroom(tmp_path, LESSONS[:1], SEED, 8) as classroom, pytest.raises(OSError, match="one"):
        classroom.show(tour.Console(record=True))
