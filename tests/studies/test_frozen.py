from frozen import dataclasses_of, thawed

import stickslip.studies


def test_dataclasses_are_frozen():
    assert dataclasses_of(stickslip.studies)
    assert thawed(stickslip.studies) == []
