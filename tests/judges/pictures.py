"""What a picture shows, read from its pixels alone."""

import numpy as np
import pytest

pygame = pytest.importorskip("pygame")

__all__ = ["AIR", "BLUE", "GREY", "INK", "MIST", "ORANGE", "box_of", "film_in", "places_of", "shown_in", "width_of"]

# Okabe and Ito's, which a reader knows from the legend of every figure.
AIR, BLUE, ORANGE = (86, 180, 233), (0, 114, 178), (213, 94, 0)
INK, GREY, MIST = (45, 52, 60), (110, 117, 125), (224, 228, 232)


def shown_in(image, colour, left=0, top=0, right=None, bottom=None):
    """Where a colour shows within a box of the picture: a mask of the box's size."""
    return (image[top:bottom, left:right] == colour).all(axis=2)


def box_of(mask):
    """Left, top, right and bottom of what is true; the last two are one beyond."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return columns[0], rows[0], columns[-1] + 1, rows[-1] + 1


def places_of(image, text, size, colour, paper=(255, 255, 255)):
    """(left, top) of every place where the text stands in the picture, to the pixel."""
    pygame.font.init()
    written = pygame.font.Font(None, size).render(text, True, colour)
    card = pygame.Surface(written.get_size())
    card.fill(paper)
    card.blit(written, (0, 0))
    glyphs = pygame.surfarray.array3d(card).transpose(1, 0, 2)
    rows, columns = np.nonzero((glyphs != paper).any(axis=2))
    rows, columns = np.append(rows, 0), np.append(columns, 0)
    height, width = (side - extent for side, extent in zip(image.shape[:2], glyphs.shape[:2], strict=True))
    found = np.array([(top, left) for top in range(height + 1) for left in range(width + 1)])
    for row, column in zip(rows, columns, strict=True):
        found = found[(image[found[:, 0] + row, found[:, 1] + column] == glyphs[row, column]).all(axis=1)]
    return [(int(left), int(top)) for top, left in found]


def width_of(text, size):
    """Pixels that a text takes."""
    pygame.font.init()
    return pygame.font.Font(None, size).size(text)[0]


def film_in(path):
    """All pictures of a film, and how many it shows in a second."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    frames = ffmpeg.read_frames(str(path))
    facts = next(frames)
    width, height = facts["size"]
    return [np.frombuffer(each, np.uint8).reshape(height, width, 3) for each in frames], facts["fps"]
