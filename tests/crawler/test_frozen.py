from frozen import dataclasses_of, thawed

import stickslip.crawler


def test_dataclasses_are_frozen():
    assert dataclasses_of(stickslip.crawler)
    assert thawed(stickslip.crawler) == []
