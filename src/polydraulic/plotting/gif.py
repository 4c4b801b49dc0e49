"""GIF files of a scene: what stands still is drawn once, and all frames share one palette."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.files import replacing
from polydraulic.plotting.drawing import Drawing
from polydraulic.plotting.frames import Frames
from polydraulic.plotting.scene import STOP, moving_artists, scene
from polydraulic.progress import Progress


class Colors(NamedTuple):
    """A palette, and which of its colours is nearest to each cell of colours."""

    table: np.ndarray  # (256, 3) uint8
    nearest: np.ndarray  # (32768,) uint8


def write_gif(frames: Frames, drawing: Drawing, path: str | Path, progress: Progress) -> None:
    """Write all frames as a GIF, whole or not at all; `progress` is told how many are done, of how many.

    A GIF counts hundredths of a second: rates that divide 100 play at the run's own speed.
    """
    total = len(frames.time)

    def counted() -> Iterator[Any]:
        for number, image in enumerate(_images(frames, drawing), start=1):
            progress("frames", number, total)
            yield image

    images = counted()
    with replacing(path) as temporary:
        pause = max(10 * round(100.0 / frames.rate), 20)  # ms; browsers slow down what is quicker
        next(images).save(temporary, format="GIF", save_all=True, append_images=images, duration=pause, loop=0)


def _images(frames: Frames, drawing: Drawing) -> Iterator[Any]:
    """Frames as palette images; what stands still is drawn once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    figure, update = scene(frames, drawing)
    figure.set_dpi(100.0)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    moving = moving_artists(figure)
    colors: Colors | None = None
    for number in range(len(frames.time)):
        update(number)
        canvas.restore_region(still)
        for artist in moving:
            figure.draw_artist(artist)
        pixels = np.asarray(canvas.buffer_rgba())[..., :3]
        colors = _colors(pixels) if colors is None else colors
        image = Image.fromarray(colors.nearest[_cell(pixels)])
        image.putpalette(colors.table.ravel().tolist())
        yield image


def _colors(pixels: np.ndarray) -> Colors:
    """The colours that most pixels of a frame have, and the one that it may lack."""
    from matplotlib.colors import to_rgb
    from scipy.spatial import cKDTree

    packed, counts = np.unique(pixels.astype(np.int64) @ np.array([65536, 256, 1]), return_counts=True)
    often = packed[np.argsort(-counts, kind="stable")]
    drawn = np.column_stack([often >> 16, often >> 8 & 255, often & 255])
    stop = np.round(255.0 * np.array(to_rgb(STOP))).astype(np.int64)
    table = np.full((256, 3), 255)
    table[: min(len(drawn), 255)], table[255] = drawn[:255], stop
    five = np.arange(32768)
    cells = np.column_stack([five >> 10, five >> 5 & 31, five & 31]) * 8 + 4
    cells[_cell(drawn[::-1])] = drawn[::-1]  # a cell stands for the colour that most of its pixels have
    return Colors(table.astype(np.uint8), cKDTree(table).query(cells)[1].astype(np.uint8))


def _cell(pixels: np.ndarray) -> np.ndarray:
    """Number of the cell of a colour, five bits per channel."""
    return np.asarray((pixels >> 3).astype(np.int64) @ np.array([1024, 32, 1]))
