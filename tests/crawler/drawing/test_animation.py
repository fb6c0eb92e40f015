import re

import numpy as np
import pytest
from pictures import film_in

from stickslip.crawler import Actuator, ChainState, Groups, simulate, State
from stickslip.crawler.drawing import film
from stickslip.crawler.drawing.animation import frames_of
from stickslip.crawler.drawing.film import write_film
from stickslip.crawler.drawing.layout import HEIGHT, WIDTH

WORD = [1, 1, 1, 0, 0]


@pytest.fixture(scope="module")
def crawl():
    return simulate(Groups(), WORD * 2, 0.5, samples_per_hold=16)


def test_every_frame_is_a_sample_and_no_more_than_two_units_of_time_pass_a_second(crawl):
    world, frames = frames_of(crawl)
    assert [each.time for each in frames] == [0.0, *crawl.time[1::2]]  # eight a hold
    assert 30 * np.diff([each.time for each in frames]).max() <= 2.0
    for frame, k in zip(frames[1:], range(1, 160, 2), strict=True):
        assert frame.stretches == (crawl.deformation[k],)
        assert (frame.pressure, frame.foot) == (crawl.pressure[k], crawl.foot[k])
        assert frame.foot_velocity == crawl.foot_velocity[k]
        # The valve as it is from this instant on.
        assert frame.valve == crawl.valve[min((k + 1) // 16, 9)]
    assert np.abs(crawl.deformation).max() == pytest.approx(1.5 * world.rest_length / 4)
    assert {each.foot_velocity > 0 for each in frames} == {True, False}


def test_a_picture_knows_the_past_and_not_the_future(crawl):
    _, frames = frames_of(crawl)
    for frame in frames[::10]:
        assert frame.past.time[-1] == frame.time
        assert frame.past.foot[-1] == frame.foot
        assert frame.past.payload[-1] == frame.foot + frame.stretches[0]


def test_slow_motion_shows_more_of_a_part(crawl):
    _, frames = frames_of(crawl, slow_motion=2.0, start=1.0, stop=2.0)
    assert [each.time for each in frames] == pytest.approx(np.arange(32, 65) / 32)


def test_si_is_the_same_film_in_other_words():
    actuator = Actuator.ecoflex()
    run = simulate(actuator, WORD, 0.5, samples_per_hold=8, initial=State(0.1, 0.0, 0.2, 0.3, 0.0))
    (_, plain), (world, frames) = frames_of(run), frames_of(run.in_si(actuator))
    assert world.units.length_name == "mm"
    for one, other in zip(plain, frames, strict=True):
        np.testing.assert_allclose(one[:1] + one[2:5], other[:1] + other[2:5], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(one.stretches, other.stretches, rtol=1e-9, atol=1e-12)
        assert one.valve == other.valve


def test_a_chain_shows_each_segment_from_the_start_on():
    scene = {"segments": 3, "tube_mass": 0.5}
    start = ChainState([0.1, 0.2, 0.3], [0.0, 0.0, 0.0])
    chain = simulate(Groups(), [1, 0], 0.5, scene=scene, samples_per_hold=8, initial=start)
    _, frames = frames_of(chain)
    assert frames[0].stretches == (0.1, 0.2, 0.3)
    for k, frame in enumerate(frames[1:]):
        assert frame.stretches == tuple(chain.segment_deformation[:, k])


def test_a_duty_cycle_shuts_the_valve_within_the_hold():
    run = simulate(Groups(), [0.25, 0.5], 1.0, samples_per_hold=16)
    _, frames = frames_of(run)
    assert [each.valve for each in frames[:16]] == [1] * 4 + [0] * 12
    assert [each.valve for each in frames[16:32]] == [1] * 8 + [0] * 8


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"file": "motion.avi"}, ValueError, "file must end in one of ['.mp4', '.gif', '.html'], got 'motion.avi'"),
        ({"file": 3}, TypeError, "file must be a path, got 3"),
        ({"file": "no/such/motion.gif"}, FileNotFoundError, "file must be in a folder that exists, got"),
        ({"slow_motion": 0.0}, ValueError, "slow_motion must be in [0.01, 1000], got 0.0"),
        ({"slow_motion": 3.0}, ValueError, "trajectory must have at least 23 samples a hold for slow_motion = 3.0"),
        ({"start": 5.0}, ValueError, "start must be in [0, 5.0), got 5.0"),
        ({"start": 1.0, "stop": 1.0}, ValueError, "stop must be in (1.0, inf), got 1.0"),
        (
            {"start": 1.0001, "stop": 1.0002},
            ValueError,
            "start and stop must have a picture between them, of which",
        ),
    ],
    ids=str,
)
def test_a_bad_argument_is_named(crawl, arguments, error, message):
    with pytest.raises(error, match=re.escape(message)):
        crawl.animate(**{"file": "motion.gif"} | arguments)


def test_a_batch_is_refused():
    with pytest.raises(ValueError, match="animate takes the trajectory of one crawler, got a batch of 2"):
        simulate([Groups()] * 2, WORD, 0.5, samples_per_hold=8).animate("motion.gif")


def test_films_of_every_kind_hold_every_picture(tmp_path):
    image = pytest.importorskip("PIL.Image")
    run = simulate(Groups(), WORD, 0.5, samples_per_hold=2)
    for kind in film.SUFFIXES:
        file = run.animate(str(tmp_path / f"motion{kind}"), slow_motion=0.25)
        assert file == tmp_path / f"motion{kind}"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["motion.gif", "motion.html", "motion.mp4"]
    pictures, fps = film_in(tmp_path / "motion.mp4")
    assert (len(pictures), fps, pictures[0].shape) == (11, 30, (HEIGHT, WIDTH, 3))
    assert np.abs(pictures[0].astype(int) - pictures[-1]).max() > 50
    with image.open(tmp_path / "motion.gif") as gif:
        assert gif.n_frames == 11
        assert gif.size == (640, 320)
        assert gif.info["loop"] == 0
    page = (tmp_path / "motion.html").read_text("utf-8")
    assert "http" not in re.sub(r'atob\(".*?"\)', "", page)  # it needs nothing else
    assert "1 / 30" in page
    assert "{film}" not in page


def test_a_film_is_written_whole_or_not_at_all(tmp_path):
    pytest.importorskip("imageio_ffmpeg")

    def broken():
        yield np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        raise RuntimeError("no more")

    for kind in film.SUFFIXES:
        (tmp_path / f"motion{kind}").write_text("as before", encoding="utf-8")
        with pytest.raises(RuntimeError, match="no more"):
            write_film(tmp_path / f"motion{kind}", broken())
        assert (tmp_path / f"motion{kind}").read_text("utf-8") == "as before"
    assert len(list(tmp_path.iterdir())) == 3


def test_a_palette_fits_an_animation_and_holds_the_colours():
    from stickslip.crawler.drawing import palette

    colours = film._colours()
    assert len(colours) <= 256
    assert {palette.PAPER, palette.INK, palette.AIR, palette.STICKING, palette.SLIDING, palette.MESSAGE} <= set(colours)
