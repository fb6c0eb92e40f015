"""Settings of the whole suite."""

import os

from hypothesis import settings

# A search that differs from run to run finds more; one that does not can be trusted to pass again.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("search", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "search")
