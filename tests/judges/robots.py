"""Clocks, sensors and valves whose every moment a test has written down."""


class ScriptedClock:
    """Stands still; whoever works lets time pass."""

    def __init__(self):
        self.time = 100.0

    def now(self):
        return self.time

    def sleep_until(self, instant):
        self.time = max(self.time, instant)


class Body:
    """A body that stays where it is, whose sensors and valve take their time."""

    def __init__(self, clock, reading=0.0, writing=0.0):
        self.clock, self.reading, self.writing = clock, iter_of(reading), iter_of(writing)
        self.turns, self.looks = [], []

    def read(self):
        self.looks.append(self.clock.now())
        self.clock.time += next(self.reading)
        return {"deformation_mm": 1.0, "foot_mm": 2.0, "pressure_kPa": 3.0}

    def write(self, valve):
        self.clock.time += next(self.writing)
        self.turns.append((self.clock.now(), valve))


def iter_of(seconds):
    """The same for ever, or what an iterator says."""
    while True:
        yield next(seconds) if hasattr(seconds, "__next__") else seconds
