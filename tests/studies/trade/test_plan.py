"""The plan: which cells a trade takes, how they are named, and what is refused."""

import json

import pytest

from stickslip.studies.trade.plan import Cell, CONDITIONED, FULL, JUDGED, LIMIT, OPEN_LOOP, QUICK, Trade, TRAINED


def test_cells_are_all_that_is_asked_for_and_each_judgement_comes_after_what_it_judges():
    trade = Trade(weights=(0.2, 0.0), dithers=(0.0, 0.1), seeds=2, floors=(0.25,), conditioned=True)
    making, distilling, judging = trade.cells()
    assert making == [
        Cell(OPEN_LOOP, 0.0),
        Cell(OPEN_LOOP, 0.1),
        Cell(LIMIT, 0.0),
        Cell(LIMIT, 0.1),
        *(Cell(TRAINED, 0.0, 0.0, seed) for seed in (0, 1)),
        *(Cell(TRAINED, 0.1, weight, seed) for seed in (0, 1) for weight in (0.0, 0.2)),
        *(Cell(TRAINED, 0.1, None, seed, floor=0.25) for seed in (0, 1)),
    ]
    [distilled] = distilling
    assert distilled[:4] == (CONDITIONED, 0.1, None, 0)
    assert trade.teachers(0.1) + trade.floored(0.1) == making[6:]
    assert len({cell.name for cell in making + distilling + judging}) == len(making) + 1 + len(judging)
    judged = [cell.judges for cell in judging]
    assert set(judged) == {cell for cell in making + distilling if cell.kind in JUDGED}
    assert judged.count(distilled) == 2  # once a weight
    assert all(cell.judges is None for cell in making)
    without = Trade(weights=(0.2, 0.0), dithers=(0.0, 0.1), seeds=2, floors=(0.25,), conditioned=False).cells()
    assert [cell for stage in without for cell in stage] == [
        cell for stage in (making, distilling, judging) for cell in stage if "conditioned" not in cell.kind
    ]


def test_every_floor_has_its_trainings_where_there_are_flips():
    trade = Trade(weights=(0.0,), dithers=(0.0, 0.1), seeds=2, floors=(0.3, 0.2), conditioned=False)
    making, _, judging = trade.cells()
    above = [cell for cell in making if cell.floor]
    assert [(cell.dither, cell.floor, cell.seed) for cell in above] == [
        (0.1, 0.2, 0), (0.1, 0.3, 0), (0.1, 0.2, 1), (0.1, 0.3, 1),
    ]  # fmt: skip
    assert {cell.judges for cell in judging if cell.floor} == set(above)


def test_names_tell_cells_apart_that_print_alike():
    assert Cell(TRAINED, 0.1, 0.2, 3).name == "policy-dither-0.1-weight-0.2-seed-3"
    assert Cell(TRAINED, 0.1, None, 3, floor=0.2).name == "policy-dither-0.1-seed-3-floor-0.2"
    near = 0.1 + 0.2
    assert f"{near:g}" == f"{0.3:g}"
    assert Cell(TRAINED, 0.1, near, 0).name != Cell(TRAINED, 0.1, 0.3, 0).name


def test_a_training_is_what_the_trade_says():
    trade = Trade(env_kwargs={"hold": 0.7, "groups": {"deborah": 0.1}}, steps=77)
    configuration = trade.configuration(0.05, 0.3, 2)
    assert configuration.env_kwargs.items() >= {"dither": 0.05, "memory_weight": 0.3, "hold": 0.7}.items()
    assert (configuration.hyperparameters["n_timesteps"], configuration.seed) == (77, 2)
    assert (configuration.start, configuration.floor) == ("even", None)
    configuration = trade.configuration(0.05, None, 2, 0.25)
    assert (configuration.start, configuration.floor) == ("policy", 0.25)
    assert "memory_weight" not in configuration.env_kwargs


def test_a_policy_of_other_teachers_is_another(tmp_path):
    names = {Trade(weights=weights, seeds=seeds).cells()[1][0].name for weights in ((0.0,), (0.1,)) for seeds in (1, 2)}
    assert len(names) == 4
    assert Trade(weights=(0.0,), seeds=1).cells()[1] == Trade(weights=(0.0,), seeds=1).cells()[1]


def test_settings_say_all_but_which_cells_are_asked_for():
    settings = Trade().settings
    assert json.loads(json.dumps(settings)) == settings
    for same in ({"weights": (0.0,)}, {"dithers": (0.2,)}, {"seeds": 9}, {"conditioned": False}):
        assert Trade(**same).settings == settings
    for other in (
        {"env_kwargs": {"hold": 0.7}},
        {"steps": 5},
        {"longest": 3},
        {"resolution": 9},
        {"judges": 3},
        {"holds": 1234},
        {"algorithm": "a2c"},
    ):
        assert Trade(**other).settings != settings, other


def test_a_changed_reward_is_told_by_the_probe():
    probe = Trade().probe()
    assert probe == Trade().probe() != Trade(env_kwargs={"delays": 3}).probe()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"weights": (0.1, 1.2)}, ValueError, r"weights must be in \[0, 1\], got 1.2"),
        ({"weights": ()}, ValueError, "weights must hold one number at least, got"),
        ({"weights": (0.1, 0.1)}, ValueError, "weights must hold no number twice"),
        ({"floors": (0.0,)}, ValueError, r"floors must be in \(0, inf\), got 0.0"),
        ({"dithers": (0.6,)}, ValueError, r"dithers must be in \[0, 0.5\], got 0.6"),
        ({"seeds": 0}, ValueError, "seeds must be a whole number >= 1, got 0"),
        ({"judges": 1}, ValueError, "judges must be a whole number >= 2, got 1"),
        ({"holds": 999}, ValueError, "holds must be a whole number >= 1000, got 999"),
        ({"longest": 2.0}, TypeError, "longest must be a whole number >= 1, got 2.0"),
        ({"steps": 0}, ValueError, "steps must be a whole number >= 1, got 0"),
        ({"env_kwargs": {"dither": 0.1}}, ValueError, "env_kwargs has no 'dither'"),
        ({"env_kwargs": {"randomize": {}}}, ValueError, "env_kwargs has no 'randomize'"),
        ({"env_kwargs": {"hold": -1}}, ValueError, "hold must be in"),
        ({"algorithm": "sac"}, ValueError, "algorithm must be one of .* got 'sac'"),
        ({"algorithm": "recurrent_ppo"}, ValueError, "must have the policy MlpPolicy, got 'MlpLstmPolicy'"),
    ],
)
def test_what_makes_no_trade_is_refused_in_one_sentence(arguments, error, message):
    with pytest.raises(error, match=message):
        Trade(**arguments)


def test_a_glance_takes_no_more_of_anything():
    assert set(QUICK) == set(FULL)
    for name, full in FULL.items():
        quick = QUICK[name]
        assert (set(quick) <= set(full)) if isinstance(full, tuple) else (quick <= full), name
