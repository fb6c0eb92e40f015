"""Pictures written as a film: mp4, gif, or a page with a player that needs nothing else."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator
from importlib import resources
from itertools import chain, product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from ...common.extras import optional_import
from ...common.files import atomically, write_text
from .palette import AIR, ELASTOMER, GREY, INK, MESSAGE, MIST, mixed, PAPER, SLIDING, STICKING

__all__ = ["FPS", "PACE", "SUFFIXES", "film_file", "write_film"]

FPS = 30
"""Pictures a second of a film."""

PACE = 2.0
"""Units of time t_c that pass in a second of film, at most: no gait that the body can follow then takes less."""

SUFFIXES = (".mp4", ".gif", ".html")
"""Kinds of film, by what their files' names end in."""

Picture = NDArray[np.uint8]

_GIF_SIZE = (640, 320)


def film_file(file: Path | str) -> Path:
    """Where a film is to be written.

    Raises
    ------
    TypeError, ValueError
        If it is no path, or of no kind of film.
    FileNotFoundError
        If there is no such folder.
    """
    if not isinstance(file, str | Path):
        raise TypeError(f"file must be a path, got {file!r}")
    file = Path(file)
    if file.suffix.lower() not in SUFFIXES:
        raise ValueError(f"file must end in one of {list(SUFFIXES)}, got {str(file)!r}")
    if not file.parent.is_dir():
        raise FileNotFoundError(f"file must be in a folder that exists, got {str(file)!r}")
    return file


def write_film(file: Path, pictures: Iterable[Picture], fps: float = FPS) -> None:
    """Write a film, whole or not at all.

    Parameters
    ----------
    file : Path
        As from `film_file`: a film in H.264 that plays everywhere, an animation of 640 by 320 pixels, or a page.
    pictures : iterable of (height, width, 3) arrays of uint8
        At least one; both sides even.
    fps : float
        Pictures a second.

    Raises
    ------
    stickslip.common.extras.MissingExtra
        Where what writes films is missing.
    """
    kind = file.suffix.lower()
    if kind == ".gif":
        atomically(file, lambda path: _write_gif(path, pictures, fps))
    elif kind == ".html":
        write_text(file, _page(pictures, fps))
    else:
        atomically(file, lambda path: _write_mp4(path, pictures, fps))


def _write_mp4(file: Path, pictures: Iterable[Picture], fps: float) -> None:
    with optional_import():
        from imageio_ffmpeg import write_frames

    several = iter(pictures)
    first = next(several)
    # A picture that can be sought every half second keeps a player's slider quick.
    options = ["-crf", "20", "-g", str(max(1, round(fps / 2))), "-movflags", "+faststart"]
    writer = write_frames(str(file), first.shape[1::-1], fps=fps, codec="libx264", quality=None, output_params=options)
    writer.send(None)
    try:
        for picture in chain([first], several):
            writer.send(np.ascontiguousarray(picture))
    finally:
        writer.close()


def _page(pictures: Iterable[Picture], fps: float) -> str:
    with TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        _write_mp4(film, pictures, fps)
        data = base64.b64encode(film.read_bytes()).decode("ascii")
    page = (resources.files(__package__) / "player.html").read_text("utf-8")
    return page.replace("{film}", data).replace("{fps}", repr(fps))


def _write_gif(file: Path, pictures: Iterable[Picture], fps: float) -> None:
    with optional_import():
        from PIL import Image

    # One palette of all colours that a picture mixes makes small files without a flicker.
    palette = Image.new("P", (1, 1))
    palette.putpalette(list(chain.from_iterable(_colours())))

    def images() -> Iterator[Image.Image]:
        for picture in pictures:
            small = Image.fromarray(picture).resize(_GIF_SIZE, Image.Resampling.BILINEAR)
            yield small.quantize(palette=palette, dither=Image.Dither.NONE)

    several = images()
    first = next(several)
    rest = list(several)
    # Times are in hundredths of a second; what is rounded off one picture's is added to the next one's.
    ends = [10 * round(100 * k / fps) for k in range(len(rest) + 2)]
    shown = np.diff(ends).tolist()
    first.save(file, save_all=True, append_images=rest, duration=shown, loop=0)


def _colours() -> list[tuple[int, int, int]]:
    """At most 256: the palette, its mixtures with what lies behind it, and the body at every pressure."""
    inks = INK, GREY, MIST, AIR, STICKING, SLIDING, MESSAGE
    mixtures = [mixed(PAPER, ink, share / 6) for ink, share in product(inks, range(1, 7))]
    mixtures += [mixed(first, second, 0.5) for first, second in product(inks, inks)]
    body = [
        mixed((40, 60, 75), mixed(ELASTOMER, AIR, pressure / 15), light)
        for pressure, light in product(range(16), (0.66, 0.72, 0.8, 0.92, 0.93, 1.0))
    ]
    return list(dict.fromkeys([PAPER, *mixtures, *body]))[:256]
