"""Settings of the whole suite."""

import os

import pytest
from hypothesis import settings

# A search that differs from run to run finds more; one that does not can be trusted to pass again.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("search", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "search")


@pytest.fixture(scope="session", autouse=True)
def _other_packages_are_not_ours_to_warn_of():
    """Keep from the processes that tests start what has this one warn of encodings left to the locale."""
    os.environ.pop("PYTHONWARNDEFAULTENCODING", None)
