"""What commands and functions know by name."""

from .common.extras import MissingExtra
from .crawler import PRESETS
from .crawler.solvers import AUTO, SOLVERS
from .studies.benchmark.sweep import SWEPT
from .studies.maps import MEASURES as MAPPED
from .studies.maps.axes import NUMBERS
from .tasks import ENCODINGS, MEASURES, RESERVOIRS, TASKS
from .train.policies.pretrained import PRETRAINED

__all__ = ["known_by_name"]


def known_by_name() -> dict[str, list[str]]:
    """Names by what they name.

    Returns
    -------
    dict of str to list of str
        Of tasks, measures, reservoirs, presets, algorithms and more. Where training is not installed the one
        algorithm says what to install.
    """
    try:
        from .train import run  # noqa: F401  (it is the first to miss the extra)
        from .train.algorithms import ALGORITHMS

        algorithms = list(ALGORITHMS)
    except MissingExtra as missing:
        algorithms = [str(missing)]
    return {
        "tasks": list(TASKS),
        "measures": list(MEASURES),
        "reservoirs": list(RESERVOIRS),
        "presets": list(PRESETS),
        "algorithms": algorithms,
        "pretrained policies": list(PRETRAINED),
        "encodings": list(ENCODINGS),
        "solvers": [AUTO, *SOLVERS],
        "sweeps": list(SWEPT),
        "numbers of a map": list(NUMBERS),
        "measures of a map": list(MAPPED),
    }
