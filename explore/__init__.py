"""``stickslip explore``: a page on which the crawler is played with.

What is seen follows from a :class:`Setup` by pure functions, from the motion to the link and the program that reproduce
it; `stickslip.explore.page`, which needs Bokeh, shows it in a browser.
"""

from .link import query_of, setup_of_query
from .presets import preset, PRESETS
from .setup import Setup, setup_of
from .snippet import program_of

__all__ = ["PRESETS", "Setup", "preset", "program_of", "query_of", "setup_of", "setup_of_query"]
