"""How soon the page of `stickslip explore` answers: from a slider's event to the plots' data in the browser.

Run ``python benchmarks/explore.py`` where Chromium and Playwright are (``make browser`` installs the latter). A process
serves the page, a browser without a window opens it, and one thing after another is moved as a hand would: the next
move comes when the last is answered. Times are those of the browser's own clock, from the event to the arrival of the
answer's last part, by when the plots have their data, and to the end of the frame after that. On a machine that others
use too a wait for the processor counts in them, so the processor's time of all processes together, server and browser,
is told as well; the crawler stands still meanwhile. The results are kept in
``benchmarks/results/explore.json``, the table is written into ``docs/explore.md``, and the page's picture into
``docs/images``; ``--picture`` makes that alone.
"""

import argparse
import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from measuring import keep, machine, refresh

from stickslip.common.files import atomically
from stickslip.studies.benchmark.report import as_markdown

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks" / "results" / "explore.json"
PAGE = ROOT / "docs" / "explore.md"
PICTURE = ROOT / "docs" / "images" / "explore.png"
QUERIES = {
    "a slider of the body, a word": ("?dither=0.1", "duffing"),
    "a slider of the body, SI": ("?units=SI", "deborah"),
    "the hold, a word": ("", "hold"),
    "a slider of the body, a policy": ("?drive=policy&policy=knee", "duffing"),
    "the hold, a policy": ("?drive=policy&policy=conditioned", "hold"),
}
"""What is moved: the link that is opened, and the slider."""

_MOVE = """async ([id, moves]) => {
    const slide = document.getElementById(id), told = window.stickslip.models.told, times = []
    const frame = () => new Promise((resolve) => requestAnimationFrame(resolve))
    for (let k = 0; k < moves; k++) {
        await new Promise((resolve) => setTimeout(resolve, 40))
        await frame()
        const answered = new Promise((resolve) => {
            const heard = () => {
                told.properties.data.change.disconnect(heard)
                resolve(performance.now())
            }
            told.properties.data.change.connect(heard)
        })
        slide.value = 1000 * (0.5 + 0.45 * Math.sin(2.4 * k))
        const begun = performance.now()
        slide.dispatchEvent(new Event("input"))
        const data = await answered - begun
        await frame()
        await frame()
        times.push([data, performance.now() - begun])
    }
    return times
}"""


def table(times: Mapping[str, Mapping[str, Any]]) -> str:
    """Milliseconds of work, to the data and to the picture, by what is moved."""
    rows = [
        ["what is moved", "processor's time (ms)", "data there, median", "95% within", "drawn, median", "95% within"]
    ]
    for name, each in times.items():
        found = [np.quantile(each[part], q) for part in ("data", "drawn") for q in (0.5, 0.95)]
        rows.append([name, *(f"{value:.0f}" for value in (each["processor"], *found))])
    return as_markdown(rows)


def main() -> None:
    """Measure, and write it down."""
    parser = argparse.ArgumentParser(description="How soon the page of `stickslip explore` answers.")
    parser.add_argument("--moves", type=int, default=60, help="of each kind")
    parser.add_argument("--picture", action="store_true", help="only the page's picture")
    chosen = parser.parse_args()
    from playwright.sync_api import sync_playwright

    program = [sys.executable, "-c", "from stickslip.cli import main; main()", "explore", "--no-open", "--port", "0"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, text=True, encoding="utf-8") as process:
        try:
            assert process.stdout is not None
            address = next(found[0] for line in process.stdout if (found := re.search(r"http://\S+", line)))
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
                times = {} if chosen.picture else _measured(browser, address, chosen.moves)
                _draw(browser, address)
                browser.close()
        finally:
            process.send_signal(signal.SIGINT)
    if chosen.picture:
        return
    keep(RESULTS, {"machine": machine("bokeh"), "moves": chosen.moves, "milliseconds": times})
    refresh(PAGE, {"answers": table(json.loads(RESULTS.read_text(encoding="utf-8"))["milliseconds"])})


def _measured(browser: Any, address: str, moves: int) -> dict[str, Any]:
    times: dict[str, Any] = {}
    for name, (query, slider) in QUERIES.items():
        page = _opened(browser, address + query)
        page.click("#play")
        page.evaluate(_MOVE, [slider, 3])
        begun = _worked()
        data, drawn = zip(*page.evaluate(_MOVE, [slider, moves]), strict=True)
        times[name] = {
            "processor": round(1000 * (_worked() - begun) / moves, 2),
            "data": [round(each, 2) for each in data],
            "drawn": [round(each, 2) for each in drawn],
        }
        print(name, f"{times[name]['processor']:.0f} ms of {np.median(data):.0f} ms", flush=True)
        page.close()
    return times


def _worked() -> float:
    """Seconds that processors have worked for the processes that this one began."""
    return sum(sum(each.cpu_times()[:2]) for each in psutil.Process().children(recursive=True))


def _draw(browser: Any, address: str) -> None:
    """Picture the page with the foot in the middle of a slide."""
    page = _opened(browser, address)
    page.wait_for_function("!document.querySelector('.stale')")
    page.wait_for_function("window.stickslip.seen.time > 9 && window.stickslip.seen.at.heading > 0")
    page.click("#play")
    page.mouse.move(0, 0)
    page.wait_for_timeout(500)
    atomically(PICTURE, lambda file: page.screenshot(path=file, full_page=True))
    page.close()


def _opened(browser: Any, address: str) -> Any:
    page = browser.new_page(viewport={"width": 1440, "height": 1000})
    page.set_default_timeout(120_000)
    page.goto(address)
    page.wait_for_function("document.getElementById('page')?.dataset.answered !== undefined")
    return page


if __name__ == "__main__":
    main()
