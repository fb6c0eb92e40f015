"""The page in a real browser without a window: what is touched changes what is seen, and nothing goes wrong."""

import io
import re
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from PIL import Image

from stickslip import simulate
from stickslip.commands import run
from stickslip.explore.link import setup_of_query
from stickslip.explore.measures import exponents_of, long_run
from stickslip.explore.motion import shown, trace_of
from stickslip.explore.presets import preset
from stickslip.explore.setup import Setup, setup_of

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium on this machine"),
    pytest.mark.xdist_group("page"),
]
pytest.importorskip("bokeh", reason='the page needs `pip install "stickslip[explore]"`: make browser')
playwright = pytest.importorskip("playwright.sync_api", reason="a browser is moved by playwright: make browser")

SECONDS = 90_000  # milliseconds that anything may take on a machine with other work
DESKTOP, PHONE = {"width": 1440, "height": 1000}, {"width": 390, "height": 844}


PROGRAM = "from stickslip.cli import main; main()"
# As if the kernels of this hold were not kept, and took until a file is there to be compiled.
COMPILING = """
import sys, time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from stickslip.compiling.compilation import NotCompiledError
from stickslip.explore.page import server, session
may, usual = Path(sys.argv.pop()), session.shown

def shown(setup, bits):
    if setup.hold == 0.75 and not may.exists():
        raise NotCompiledError("a kernel is not compiled yet")
    return usual(setup, bits)

def compile_kernels(setup):
    while not may.exists():
        time.sleep(0.05)

session.shown, session.compile_kernels, server.worker_processes = shown, compile_kernels, ThreadPoolExecutor
"""


@contextmanager
def served(*options, program=PROGRAM):
    """A process that serves the page, and where."""
    command = [sys.executable, "-c", program, "explore", "--no-open", "--port", "0", *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, encoding="utf-8")
    said = []
    try:
        for line in process.stdout:
            said.append(line)
            if found := re.search(r"http://\S+", line):
                yield found[0]
                break
        else:
            pytest.fail("".join(said))
    finally:
        process.send_signal(signal.SIGINT)
        said.append(process.communicate(timeout=60)[0])
    assert "Traceback" not in "".join(said), "".join(said)
    assert process.returncode == 130


@pytest.fixture(scope="module")
def address():
    with served() as found:
        yield found


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture
def opened(browser, address):
    """Open a page at a link, ready and measured; nothing may be logged as an error until the test is over."""
    with opening(browser, address) as open_:
        yield open_


@contextmanager
def opening(browser, address):
    contexts, faults = [], []

    def open_(query="", viewport=DESKTOP, **options):
        context = browser.new_context(viewport=viewport, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(SECONDS)
        page.on("console", lambda each: faults.append(each.text) if each.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("requestfailed", lambda request: faults.append(request.url))
        page.goto(address + query)
        page.wait_for_function("document.getElementById('page')?.dataset.answered !== undefined")
        measured(page)
        return page

    yield open_
    for context in contexts:
        context.close()
    assert faults == []


def measured(page):
    """Wait until nothing is stale."""
    page.wait_for_function("!document.querySelector('.stale')")


def answered(page, action):
    """Do something, and wait until what it asks for is answered."""
    before = page.evaluate("Number(document.getElementById('page').dataset.answered)")
    action()
    page.wait_for_function(f"Number(document.getElementById('page').dataset.answered) > {before}")


def told(page):
    return page.evaluate("window.stickslip.seen.told")


def trace(page):
    """What the browser draws, column by column."""
    columns = page.evaluate(
        "Object.fromEntries(Object.entries(window.stickslip.models.trace.data).map(([k, v]) => [k, Array.from(v)]))"
    )
    return {name: np.array(column, np.float64) for name, column in columns.items()}


def assert_drawn(page, setup):
    """The browser draws what Python finds for a setup, to the last bit."""
    seen, expected = trace(page), trace_of(setup, shown(setup))
    assert set(seen) == set(expected)
    for name, column in expected.items():
        np.testing.assert_array_equal(seen[name], column, err_msg=name)


def pixels(page, selector):
    """Colours of an element and how many pixels have each, as somebody sees it."""
    picture = Image.open(io.BytesIO(page.locator(selector).screenshot())).convert("RGB")
    return {colour: count for count, colour in picture.getcolors(picture.width * picture.height)}


def test_it_loads_and_shows_the_default_crawler(opened):
    page = opened()
    assert_drawn(page, Setup())
    assert page.title() == "stickslip explore"
    run_, spectrum = long_run(Setup()), exponents_of(Setup(), long_run(Setup()).valve)
    assert page.inner_text("#speed").startswith(f"{run_.speed:.2f}")
    assert page.inner_text("#memory").startswith(f"{run_.memory.corrected:.2f}")
    assert page.inner_text("#exponent").replace("−", "-").startswith(f"{spectrum.exponents[0]:.3f}")
    assert "contracting" in page.inner_text("#exponent-more")
    # Bokeh has drawn four plots.
    sizes = page.locator(".plot canvas.bk-layer, .plot canvas").evaluate_all("all => all.map(each => each.width)")
    assert len([size for size in sizes if size > 200]) >= 4


def test_the_crawler_moves_and_its_foot_is_seen_to_stick_and_to_slide(opened):
    page = opened("?preset=clean-gait")
    page.click("[data-pace='6']")
    stick, slip = (0, 114, 178), (213, 94, 0)
    seen = set()
    for _ in range(60):
        counts = pixels(page, "#stage")
        seen |= {"sticks"} if counts.get(stick, 0) > 800 > counts.get(slip, 0) else set()
        seen |= {"slides"} if counts.get(slip, 0) > 800 > counts.get(stick, 0) else set()
        if len(seen) == 2:
            break
        page.wait_for_timeout(120)
    assert seen == {"sticks", "slides"}
    page.click("#play")
    still = page.evaluate("window.stickslip.seen.time")
    page.wait_for_timeout(300)
    assert page.evaluate("window.stickslip.seen.time") == still


def test_a_slider_changes_the_plot(opened):
    page = opened()
    before = trace(page)["foot"]
    page.focus("#duffing")
    answered(page, lambda: page.keyboard.press("ArrowRight"))
    answered(page, lambda: page.keyboard.press("PageUp"))
    value = told(page)["setup"]["duffing"]
    assert 0.5 < value < 5.0
    assert page.input_value("#duffing-exact") == f"{value:g}"
    page.wait_for_function("!document.querySelector('.stale')")
    assert not np.array_equal(trace(page)["foot"], before)
    assert_drawn(page, setup_of({"duffing": value}))


def test_a_number_is_typed_exactly_and_refused_in_a_sentence(opened):
    page = opened()
    page.fill("#hold-exact", "0.75")
    answered(page, lambda: page.press("#hold-exact", "Enter"))
    assert_drawn(page, setup_of({"hold": 0.75}))
    page.fill("#hold-exact", "-1")
    answered(page, lambda: page.press("#hold-exact", "Enter"))
    assert page.inner_text("#notice") == "hold must be in [0.05, 5], got -1"
    assert page.input_value("#hold-exact") == "0.75"
    page.fill("#kinetic_friction-exact", "0.45")
    answered(page, lambda: page.press("#kinetic_friction-exact", "Enter"))
    assert page.input_value("#static_friction-exact") == "0.45"
    assert page.is_hidden("#notice")


def test_a_word_changes_the_gait(opened):
    page = opened("?dither=0")
    speed = page.inner_text("#speed")
    answered(page, lambda: page.click("#bits button:nth-child(2)"))
    assert told(page)["setup"]["word"] == "10100111000"
    assert_drawn(page, setup_of({"dither": 0.0, "word": "10100111000"}))
    measured(page)
    assert page.inner_text("#speed") != speed
    answered(page, lambda: page.click("#more"))
    page.fill("#word", "10")
    answered(page, lambda: page.press("#word", "Enter"))
    assert page.locator("#bits button").count() == 2
    assert_drawn(page, setup_of({"dither": 0.0, "word": "10"}))


def test_the_space_bar_opens_the_valve(opened):
    page = opened()
    page.click("h1")
    answered(page, lambda: page.keyboard.down("Space"))
    page.wait_for_function("window.stickslip.seen.told.setup.drive === 'live'")
    page.wait_for_function("window.stickslip.seen.told.holds > 5")
    page.keyboard.up("Space")
    page.wait_for_function("window.stickslip.seen.told.holds > 10")
    page.click("#play")
    page.wait_for_timeout(400)
    (bits,) = re.findall(r'"([01]+)"', told(page)["program"])
    assert re.fullmatch(r"0+1+0+", bits), bits
    motion = simulate({}, [int(bit) for bit in bits], 0.5, samples_per_hold=17)
    np.testing.assert_array_equal(trace(page)["foot"][1:], motion.foot)
    page.click("#keep")  # the answer to a bit may be on its way
    page.wait_for_function("window.stickslip.seen.told.setup.drive === 'word'")
    assert told(page)["setup"]["word"] == bits[-32:]


def test_a_finger_opens_the_valve_too(opened):
    page = opened("?drive=live", viewport=PHONE, is_mobile=True, has_touch=True)
    page.dispatch_event("#hold-open", "pointerdown")
    page.wait_for_function("window.stickslip.seen.told.program.includes('111')")
    page.dispatch_event("body", "pointerup")
    page.wait_for_function('/1110+"/.test(window.stickslip.seen.told.program)')


def test_a_policy_is_let_act(opened):
    page = opened()
    answered(page, lambda: page.click("[data-drive='policy'][role='radio']"))
    assert_drawn(page, preset("knee-policy"))
    assert page.is_hidden("#weighed")
    answered(page, lambda: page.click("[data-policy='conditioned']"))
    assert page.is_visible("#weighed")
    assert_drawn(page, setup_of({"policy": "conditioned"}, preset("knee-policy")))


def test_a_link_restores_what_was_seen(opened):
    page = opened("?duffing=2.5&word=1100&units=SI&hold=0.4&slope=0.05")
    setup = setup_of({"duffing": 2.5, "word": "1100", "units": "SI", "hold": 0.4, "slope": 0.05})
    assert_drawn(page, setup)
    assert page.inner_text("#hold-si") == "h = 25 ms"
    page.fill("#damping_ratio-exact", "0.2")
    answered(page, lambda: page.press("#damping_ratio-exact", "Enter"))
    page.wait_for_function("location.search.includes('damping_ratio')")
    query = page.evaluate("location.search")
    assert setup_of_query(query) == setup_of({"damping_ratio": 0.2}, setup)
    assert_drawn(opened(query), setup_of({"damping_ratio": 0.2}, setup))


def test_a_forged_link_is_told_of_in_a_sentence(opened):
    page = opened("?word=<img src=x onerror=alert(1)>&hold=1")
    said = page.inner_text("#notice")
    assert said == (
        "This link is not followed: word must be 1 to 32 letters 0 and 1, got '<img src=x onerror=alert(1)>'."
    )
    assert page.locator("#notice img").count() == 0
    assert_drawn(page, Setup())
    page = opened("?word=%ff")  # which is no UTF-8
    assert page.inner_text("#notice").startswith("This link is not followed: word must be 1 to 32 letters 0 and 1")


def test_switches_clamp_the_foot_and_take_its_ratchet(opened):
    page = opened("?slope=-0.08")
    assert page.is_checked("#ratchet")
    answered(page, lambda: page.uncheck("#ratchet"))
    setup = setup_of({"slope": -0.08, "ratchet": False})
    assert_drawn(page, setup)
    assert (np.diff(trace(page)["foot"]) < 0).any()
    answered(page, lambda: page.check("#anchored"))
    setup = setup_of({"anchored": True}, setup)
    assert_drawn(page, setup)
    assert not trace(page)["foot"].any()
    assert page.locator(".idle").evaluate_all("all => all.map(each => each.dataset.number ?? each.dataset.switch)") == [
        "static_friction",
        "kinetic_friction",
        "ratchet",
    ]
    measured(page)
    assert page.inner_text("#speed").startswith("0.00")
    assert page.inner_text("#memory").startswith(f"{long_run(setup).memory.corrected:.2f}")
    page.wait_for_function("location.search.includes('anchored=true')")
    assert setup_of_query(page.evaluate("location.search")) == setup
    assert "Scene(anchored=True, ratchet=False, slope=-0.08)" in told(page)["program"]
    again = opened("?anchored=true&ratchet=false")
    assert_drawn(again, setup_of({"anchored": True, "ratchet": False}))
    assert again.is_checked("#anchored")
    assert not again.is_checked("#ratchet")


def test_while_a_kernel_is_compiled_the_page_lives(browser, tmp_path):
    may = tmp_path / "may"
    with served(str(may), program=COMPILING + PROGRAM) as found, opening(browser, found) as open_:
        page = open_()
        page.fill("#hold-exact", "0.75")
        answered(page, lambda: page.press("#hold-exact", "Enter"))
        line = "Compiling what this needs: up to a minute, once. What is drawn is from before."
        assert page.inner_text("#notice") == line
        assert_drawn(page, Setup())
        # The crawler goes on, and another change of what is not compiled changes what is shown of it.
        before = page.evaluate("window.stickslip.seen.time")
        page.wait_for_function(f"window.stickslip.seen.time !== {before}")
        answered(page, lambda: page.click("#bits button:nth-child(2)"))
        assert page.inner_text("#notice") == line
        assert page.input_value("#word") == "10100111000"
        assert_drawn(page, Setup())
        # What is compiled is answered at once, beside the compiler.
        page.fill("#hold-exact", "0.5")
        answered(page, lambda: page.press("#hold-exact", "Enter"))
        assert page.is_hidden("#notice")
        assert_drawn(page, setup_of({"word": "10100111000"}))
        measured(page)
        page.fill("#hold-exact", "0.75")
        answered(page, lambda: page.press("#hold-exact", "Enter"))
        assert page.inner_text("#notice") == line
        may.touch()
        page.wait_for_function("document.getElementById('notice').hidden")
        measured(page)
        assert_drawn(page, setup_of({"word": "10100111000", "hold": 0.75}))


def test_the_program_is_shown_and_a_preset_taken(opened):
    page = opened()
    answered(page, lambda: page.select_option("#preset", "uphill"))
    assert_drawn(page, preset("uphill"))
    page.click("#show-program")
    assert page.inner_text("#program").strip() == told(page)["program"].strip()
    assert "scene = Scene(slope=0.08)" in page.inner_text("#program")
    page.click("#close-program")
    assert page.is_hidden("#program-dialog")


def test_without_flips_it_is_said_that_there_is_no_memory(opened):
    page = opened("?dither=0")
    assert page.inner_text("#memory") == "–"
    assert page.inner_text("#no-memory") == "Without flips there is no message to remember."


@pytest.mark.parametrize(
    "viewport",
    [DESKTOP, {"width": 1024, "height": 768}, PHONE, {"width": 320, "height": 640}],
    ids=lambda v: v["width"],
)
@pytest.mark.parametrize(
    "query", ["", "?units=SI&drive=policy&policy=conditioned", "?drive=live", "?preset=no-ratchet"]
)
def test_nothing_overlaps_and_nothing_is_scrolled_to_the_side(opened, viewport, query):
    page = opened(query, viewport=viewport)
    assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    boxes = page.evaluate(
        """[...document.querySelectorAll(".card, .metric, header")].map((each) => {
            const box = each.getBoundingClientRect()
            return [each.className || each.tagName, box.left, box.top, box.right, box.bottom]
        })"""
    )
    for i, (name, left, top, right, bottom) in enumerate(boxes):
        assert left >= 0, name
        assert right <= viewport["width"], name
        for other, *box in boxes[i + 1 :]:
            apart = right <= box[0] or box[2] <= left or bottom <= box[1] or box[3] <= top
            assert apart, (name, other)
    # No text is cut off in buttons, and no label is hidden by its number.
    cut = page.evaluate(
        """[...document.querySelectorAll("button, .number label, .switch, .metric b, .metric small, h2, .caption")]
            .filter((each) => each.offsetParent && each.scrollWidth > each.clientWidth + 1)
            .map((each) => each.id || each.textContent)"""
    )
    assert cut == []


def test_a_visitor_s_page_is_his_own(opened):
    one, other = opened(), opened()
    answered(one, lambda: one.click("#bits button:nth-child(1)"))
    assert told(one)["setup"]["word"] != told(other)["setup"]["word"]
    assert_drawn(other, Setup())


def test_this_machine_alone_is_served(address):
    port = int(re.search(r":(\d+)/", address)[1])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing, and tells which address would
        except OSError:
            pytest.skip("this machine has no other address than its own")
        own = probe.getsockname()[0]
    if own.startswith("127."):
        pytest.skip("this machine has no other address than its own")
    with pytest.raises(ConnectionRefusedError), socket.create_connection((own, port), timeout=5):
        pass


def test_a_port_in_use_and_an_unknown_preset_are_refused_in_a_sentence(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert run(["explore", "--no-open", "--port", str(port)]) == 1
    assert capsys.readouterr().err == f"error: port must be free, got {port}: something else listens there\n"
    assert run(["explore", "--no-open", "--preset", "nosuch"]) == 1
    assert capsys.readouterr().err.startswith("error: preset must be one of ['fastest-word', ")
    assert run(["explore", "--no-open", "--port", "70000"]) == 1
    assert "--port must be a whole number in [0, 65535], got 70000" in capsys.readouterr().err
    assert run(["explore", "--no-open", "--groups", '{"duffing": 50}']) == 1
    assert "duffing must be in [0, 20], got 50" in capsys.readouterr().err
