"""Cost and error of the Taylor solver by order and tolerance: whence `stickslip.crawler.steps.taylor.order_for` comes.

Run ``python benchmarks/taylor_order.py``. Orders are timed in turn, round after round, so that the machine's drift
falls on all alike; the median is printed, as a ratio to the cheapest order of the row.
"""

import time

import numpy as np

from stickslip.crawler import Groups, Scene
from stickslip.crawler.drive import drive
from stickslip.crawler.model.state import Body, coefficients_of
from stickslip.crawler.solvers import SOLVERS
from stickslip.crawler.steps.options import TAYLOR
from stickslip.crawler.steps.taylor import order_for, ORDERS
from stickslip.crawler.steps.workspace import ROWS, WIDTH

WORD = np.array([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0] * 25)
FOOT = 32.03368882790800707974502  # 40-digit arithmetic
ROUNDS = 31


def main() -> None:
    """Print the table."""
    coefficients = coefficients_of(Groups(), Scene())
    rest = Body(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0)
    samples, events, series = np.empty((5, len(WORD))), np.empty((0, 2)), np.empty((ROWS, WIDTH))
    print("relative cost (error of the foot after 200 time units); * marks the order chosen")
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15):
        seconds: dict[int, list[float]] = {order: [] for order in ORDERS}
        error = {}
        for _ in range(ROUNDS):
            for order in ORDERS:
                options = SOLVERS["taylor"].options(tolerance)._replace(order=order, method=TAYLOR[order]())
                start = time.perf_counter()
                drive(rest, coefficients, WORD, 1.0, options, samples, events, series)
                seconds[order].append(time.perf_counter() - start)
                error[order] = abs(samples[3, -1] - FOOT)
        cost = {order: float(np.median(times)) for order, times in seconds.items()}
        least = min(cost.values())
        cells = [
            f"{order}{'*' if order == order_for(tolerance) else ''}: {cost[order] / least:.2f} ({error[order]:.0e})"
            for order in ORDERS
        ]
        print(f"{tolerance:g}  " + "  ".join(cells))


if __name__ == "__main__":
    main()
