"""What a reproduction is asked for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Asked"]


@dataclass(frozen=True)
class Asked:
    """How much is measured, and where what takes long is kept.

    Attributes
    ----------
    folder : Path
        Of maps, which an interrupted run goes on with.
    quick : bool
        Three seeds instead of eight, and less of all else.
    processes : int
        That share maps.
    show : callable
        Told what begins.
    """

    folder: Path
    quick: bool = False
    processes: int = 1
    show: Callable[[str], object] = lambda _: None

    @property
    def seeds(self) -> Sequence[int]:
        """Of inputs and noise."""
        return range(3) if self.quick else range(8)
