"""Blocks of a log: equally many rows each, with rows before and after that filters and pilots need."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

BLOCK = 1.0  # s: what is judged at once
BEFORE, AFTER = 1.0, 0.36  # s: spools forget where they began; filters end
LINE_WINDOW = 0.5  # s, over which volumes are balanced
MOTION_STRIDE = 0.1  # s between rows at which torques are compared
FILTER, FAR = 0.07, 4.0  # s, width of the filter of motions, and widths after which it ends
SMOOTH = 7  # rows over which spools and positions are smoothed


class BlockShape(NamedTuple):
    """Rows of a block.

    Attributes
    ----------
    raster : float, s
    before, inside, after : int
        How many rows of a block come before what is judged, are judged, and come after it.
    """

    raster: float
    before: int
    inside: int
    after: int

    @property
    def rows(self) -> int:
        """All of them."""
        return self.before + self.inside + self.after

    @property
    def judged(self) -> slice:
        """Those that are judged."""
        return slice(self.before, self.before + self.inside)

    @property
    def seconds(self) -> float:
        """How long what is judged lasts."""
        return self.inside * self.raster

    @property
    def window(self) -> int:
        """Steps of a window over which volumes are balanced."""
        return max(2, self.inside // max(1, round(BLOCK / LINE_WINDOW)))


def block_shape(raster: float) -> BlockShape:
    """Rows of blocks of a log with so many seconds between rows."""
    return BlockShape(raster, round(BEFORE / raster), max(4, round(BLOCK / raster)), round(AFTER / raster))


def piece_ends(time: np.ndarray, segment: np.ndarray, raster: float) -> np.ndarray:
    """Rows at which a piece without a gap ends and the next begins, (n_piece - 1,)."""
    return np.flatnonzero((np.diff(segment) != 0) | (np.diff(time) > 1.5 * raster)) + 1


def starts_of(time: np.ndarray, segment: np.ndarray, shape: BlockShape) -> np.ndarray:
    """First rows of blocks whose judged rows follow each other; none goes over a gap or the end of a segment, (n_block,)."""
    ends = [0, *piece_ends(time, segment, shape.raster).tolist(), len(time)]
    found = [np.arange(begin, end - shape.rows + 1, shape.inside) for begin, end in pairwise(ends)]
    return np.concatenate(found).astype(np.int64)


def smoothing(rows: int) -> np.ndarray:
    """Weights of local parabolas over so many rows, (rows,)."""
    at = np.arange(rows) - (rows - 1) / 2
    return np.asarray(np.linalg.pinv(np.vander(at, 3))[2])


def motion_filters(raster: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights over samples that smooth, and that give first and second derivative of what is smoothed; cubics pass as they are."""
    half = max(3, int(np.ceil(FAR * FILTER / raster)))
    at = np.arange(-half, half + 1) * raster
    s2 = (at / FILTER) ** 2
    bell = np.exp(-0.5 * s2)
    smooth, slope = bell * (1.5 - 0.5 * s2), at * bell * (2.5 - 0.5 * s2)
    curve = bell * (-2.5 + 4.0 * s2 - 0.5 * s2**2)
    curve = curve - curve.mean()
    return smooth / smooth.sum(), slope / (slope @ at), curve / (curve @ (0.5 * at**2))
