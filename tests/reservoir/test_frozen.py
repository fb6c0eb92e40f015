from frozen import dataclasses_of, thawed

import stickslip.reservoir


def test_dataclasses_are_frozen():
    assert dataclasses_of(stickslip.reservoir)
    assert thawed(stickslip.reservoir) == []
