"""The words of a claim, and the figures that it is shown in."""

import re
from pathlib import Path

import pytest

from stickslip.studies.claims.claim import CLAIMS, FIGURES, INDEPENDENT

NAMED = re.compile(r"Fig\. (\d+)|\b(S\d+)")


@pytest.mark.parametrize("name", sorted(set(CLAIMS) - {"C10"}))  # which names equations of the supplement
def test_the_figures_that_a_claim_names_are_those_that_are_drawn_for_it(name):
    named = {f"fig{number or of_the_supplement}" for number, of_the_supplement in NAMED.findall(CLAIMS[name])}
    assert named <= set(FIGURES[name])
    assert named or name == "C9"  # of which the paper has no figure


def test_every_claim_is_judged_by_a_test_that_is_there():
    assert list(INDEPENDENT) == list(CLAIMS)
    for _, test in INDEPENDENT.values():
        assert (Path(__file__).parents[3] / test).is_file()
