"""Every recipe of `docs/recipes.md`, run as it stands there with the real package."""

import os
import subprocess

import pytest
from checks import CHECKS
from environments import python_of
from page import recipes, ROOT

FEW_SECONDS = {"Gymnasium"}


def test_every_recipe_is_checked():
    assert set(recipes()) == set(CHECKS)


@pytest.mark.parametrize(
    "name", [name if name in FEW_SECONDS else pytest.param(name, marks=pytest.mark.slow) for name in CHECKS]
)
def test_a_recipe_runs_and_agrees_with_the_environment_alone(name, tmp_path):
    quiet = {
        "HOME": str(tmp_path),  # for what packages leave there
        "SDL_VIDEODRIVER": "dummy",
        "SDL_AUDIODRIVER": "dummy",
        "RAY_AUTH_MODE": "disabled",
        "RAY_USAGE_STATS_ENABLED": "0",
        "PYTHONPATH": str(ROOT / "tests" / "interop"),
    }
    subprocess.run(
        [python_of(name.lower()), ROOT / "tests" / "interop" / "page.py", name],
        cwd=tmp_path,
        env={**os.environ, **quiet},
        check=True,
        timeout=900,
    )
