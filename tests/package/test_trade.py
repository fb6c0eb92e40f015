"""``stickslip trade``: what it is asked for; `test_kills` kills it."""

import pytest

from stickslip.commands import run
from stickslip.studies.trade import report, running
from stickslip.studies.trade.plan import FULL, OPEN_LOOP, QUICK, Trade
from stickslip.studies.trade.running import Finished

HYPERPARAMETERS = """
StickSlipCrawler-v0:
  n_envs: 4
  n_timesteps: 1500
  policy: MlpPolicy
  n_steps: 64
  batch_size: 64
  n_epochs: 2
  policy_kwargs: dict(net_arch=[8])
"""
WORDS = {"names": ["1"], "speeds": [[0.1, 0.2]], "memories": [[3.0, 3.1]]}
NUMBERS = {
    "speeds": [0.1, 0.2],
    "memories": [3.0, 3.1],
    "episodes": {"speeds": [0.1, 0.1], "memories": [2.0, 2.0]},
}


@pytest.fixture
def asked(monkeypatch):
    """The trades that are asked for, and how their work is to be shared; none of it is done."""
    found = []

    class Folder:
        def __init__(self, folder, trade):
            self.folder, self.trade = folder, trade

        def run(self, **sharing):
            found.append((self.folder, self.trade, sharing))
            yield Finished(0, 2, None)
            yield Finished(2, 2, None)

        def results(self):
            cells = [cell for stage in self.trade.cells() for cell in stage]
            held = {"names": ["0", "1"], "speeds": [[0.0, 0.0]] * 2, "memories": [[3.0, 3.0]] * 2}
            kinds = {OPEN_LOOP: {"front": WORDS, "held": held}, "speed limit": {"speeds": [0.8, 0.9]}}
            return {cell: kinds.get(cell.kind, NUMBERS) for cell in cells}

    monkeypatch.setattr(running, "TradeFolder", Folder)
    monkeypatch.setattr(report, "write_report", lambda *_, **__: None)
    return found


def test_a_trade_is_asked_for_option_by_option(asked, capsys, tmp_path):
    file = tmp_path / "own.yml"
    file.write_text(HYPERPARAMETERS, encoding="utf-8")
    command = f"trade --output {tmp_path} --weights 0,0.5 --dithers 0.05,0.2 --seeds 2 --hold 0.75 --algorithm a2c"
    command += f" --hyperparameters {file} --steps 90 --longest 5 --resolution 9 --judges 3 --holds 1200 --processes 3"
    options = [
        "--no-conditioned",
        "--floors",
        "0.25,0.3",
        "--groups",
        '{"duffing": 2}',
        "--env-kwargs",
        '{"delays": 3}',
        "--dask",
        "tcp://here",
    ]
    assert run([*command.split(), *options]) == 0
    [(folder, trade, sharing)] = asked
    assert folder == tmp_path
    assert sharing == {"processes": 3, "dask": "tcp://here"}
    assert trade == Trade(
        weights=(0.0, 0.5),
        dithers=(0.05, 0.2),
        seeds=2,
        floors=(0.25, 0.3),
        env_kwargs={"hold": 0.75, "groups": {"duffing": 2}, "delays": 3},
        algorithm="a2c",
        hyperparameters=trade.hyperparameters,
        conditioned=False,
        longest=5,
        resolution=9,
        judges=3,
        holds=1200,
        steps=90,
    )
    assert trade.hyperparameters["n_timesteps"] == 90
    assert trade.hyperparameters["batch_size"] == 64
    printed = " ".join(capsys.readouterr().out.split())
    assert "dither 0.05, mean [95% interval] over 3 seeds" in printed
    assert "dither 0.2, mean [95% interval] over 3 seeds" in printed


@pytest.mark.parametrize(("option", "defaults"), [([], FULL), (["--quick"], QUICK)])
def test_what_is_not_said_of_a_trade_is_a_full_or_a_quick_one(asked, option, defaults):
    assert run(["trade", *option]) == 0
    assert run(["trade", *option, "--judges", "7"]) == 0
    env_kwargs = {"hold": 0.5}
    assert [each[1] for each in asked] == [
        Trade(**defaults, env_kwargs=env_kwargs),
        Trade(**{**defaults, "judges": 7}, env_kwargs=env_kwargs),
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--weights", "0,x"], "error: --weights must be numbers with commas between them, got '0,x'"),
        (["--env-kwargs", '{"hold": 1}'], "error: --env-kwargs must not set hold: it has an option of its own"),
        (["--processes", "0"], "error: --processes must be a whole number >= 1, got 0"),
        (["--dithers", "0.7"], "error: dithers must be in [0, 0.5], got 0.7"),
    ],
)
def test_a_trade_of_what_cannot_be_is_refused(capsys, tmp_path, options, message):
    assert run(["trade", "--output", str(tmp_path / "t"), *options]) == 1
    assert capsys.readouterr().err.strip() == message
    assert not (tmp_path / "t").exists()
