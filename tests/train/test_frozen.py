from frozen import dataclasses_of, thawed

import stickslip.train


def test_dataclasses_are_frozen():
    assert dataclasses_of(stickslip.train)
    assert thawed(stickslip.train) == []
