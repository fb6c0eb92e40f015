from frozen import dataclasses_of, thawed

import stickslip.envs


def test_dataclasses_are_frozen():
    assert dataclasses_of(stickslip.envs)
    assert thawed(stickslip.envs) == []
