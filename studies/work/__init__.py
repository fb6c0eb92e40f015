"""Work of the pressure over ensembles of inputs and of starts: its balance, its spread, and Jarzynski's average."""

from .ensembles import boltzmann_starts, Works, works_of
from .jarzynski import Average, average
from .smooth import smooth_works
from .split import Split, split

__all__ = ["Average", "Split", "Works", "average", "boltzmann_starts", "smooth_works", "split", "works_of"]
