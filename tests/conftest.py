"""Settings of the whole suite."""

import os

import pytest
from hypothesis import settings
from matplotlib import pyplot as plt

from stickslip.train import verdict

# `gymnasium.utils.play` asks for a window when it is imported, but not where figures have a backend already.
plt.switch_backend("agg")

# A search that does not differ from run to run can be trusted to pass again; one that does finds more (`make night`),
# and prints how to reproduce what it finds.
settings.register_profile("ci", derandomize=True, deadline=None, database=None)
settings.register_profile("night", deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


@pytest.fixture(scope="session", autouse=True)
def _trainings_are_judged_briefly():
    """Over few steps and words: what a training came to takes seconds to tell, and no test but its own asks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verdict, "STANDARD", verdict.Judging(seeds=2, steps=40, burn_in=10, longest_word=3))
        yield


@pytest.fixture(scope="session", autouse=True)
def _other_packages_are_not_ours_to_warn_of():
    """Keep from the processes that tests start what has this one warn of encodings left to the locale."""
    os.environ.pop("PYTHONWARNDEFAULTENCODING", None)


@pytest.fixture(scope="session", autouse=True)
def _the_record_of_what_was_written_is_not_the_user_s_own(tmp_path_factory):
    """Keep what trainings of the tests note (`stickslip.train.trust`) out of the home of whoever runs them."""
    os.environ["XDG_STATE_HOME"] = os.environ["LOCALAPPDATA"] = str(tmp_path_factory.mktemp("state"))
