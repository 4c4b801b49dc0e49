"""Whether a sensor's error came at once and stays, a bias, or grows, a drift: both fitted to the blocks about an alarm's beginning.

Either may have begun at any of some blocks; what speaks for it is averaged over these and over its size, as for any other fault.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.watch.block import BlockJudge
from polydraulic.watch.diagnosis import Suspect, sized
from polydraulic.watch.directions import Direction
from polydraulic.watch.kernels.evidence import ELSE, KEPT
from polydraulic.watch.kernels.numbers import BLOCKS, FIRST, OPENED

BIAS, DRIFT = ".bias", ".drift"
BEFORE = 300  # blocks before an alarm seems to have begun, in which a drift may have
_BEGINNINGS = 60  # blocks at which either may have begun that are tried


class ErrorCourse(NamedTuple):
    """How an error went on in time.

    Attributes
    ----------
    grows : float
        Probability that it grew evenly rather than came at once.
    size, error : float
        Of one that grew, by now, in sizes of the direction, with a standard error.
    past : bool
        Whether it is of blocks that are no longer kept.
    """

    grows: float
    size: float
    error: float
    past: bool = False


def course_of(pull: np.ndarray, information: np.ndarray, together: float) -> ErrorCourse:
    """How the error went on that blocks are pulled by.

    Parameters
    ----------
    pull, information : (n_block,) array
        Whitened scores of one direction, from before the error began until now.
    together : float
        What evidence is divided by.
    """
    n = len(pull)
    first = np.unique(np.linspace(0.0, n - 1.0, _BEGINNINGS).astype(int))
    at = np.arange(n)[None, :] - first[:, None]
    since = at >= 0
    grown = np.where(since, (at + 1.0) / (n - first)[:, None], 0.0)
    step, ramp = (_fit(shape, pull, information) for shape in (since.astype(np.float64), grown))
    counts = int((information > 0.0).sum())
    scatter = max(min(float(fit.left.min()) for fit in (step, ramp)) / max(counts - 1, 1), together)
    speaks = [0.5 * (f.size**2 * f.known / scatter - np.log1p(f.known / scatter)) for f in (step, ramp)]
    highest = max(float(evidence.max()) for evidence in speaks)
    stays, grows = (float(np.exp(evidence - highest).sum()) for evidence in speaks)
    best = int(np.argmax(speaks[1]))
    return ErrorCourse(grows / (stays + grows), float(ramp.size[best]), float(np.sqrt(scatter / ramp.known[best])))


def course_so_far(
    suspects: Sequence[Suspect], directions: Sequence[Direction], judge: BlockJudge, known: ErrorCourse | None
) -> ErrorCourse | None:
    """The course of the first suspect, if it is an error of a sensor; of a beginning that is no longer kept, what was known of it.

    Parameters
    ----------
    suspects : sequence of Suspect
        From `named_suspects`.
    directions : sequence of Direction
    judge : BlockJudge
        Of the blocks so far.
    known : ErrorCourse or None
        Of the blocks before.
    """
    if not (suspects and suspects[0].name.endswith(BIAS)):
        return None
    opened, first = int(judge.marks[OPENED]), int(judge.marks[FIRST])
    # blocks in which another sensor stayed are left out
    begin = max(opened - BEFORE, 0) if first == opened else first
    if known is not None and begin < int(judge.marks[BLOCKS]) - KEPT:
        return known._replace(past=True)
    place = _place(suspects[0], directions)
    return course_of(*judge.course(place, begin), float(judge.numbers.together[place]))


def with_course(
    suspects: Sequence[Suspect], directions: Sequence[Direction], course: ErrorCourse | None
) -> tuple[Suspect, ...]:
    """Suspects, of whom the first is two if it is an error of a sensor: a bias and a drift, as likely as its course makes them.

    Parameters
    ----------
    suspects : sequence of Suspect
        From `named_suspects`.
    directions : sequence of Direction
    course : ErrorCourse or None
        From `course_so_far`.
    """
    if course is None:
        return tuple(suspects)
    bias = suspects[0]
    column, whole = bias.name.removesuffix(BIAS), directions[_place(bias, directions)].size
    when = "in the first minutes of the alarm" if course.past else "by now"
    title = sized(
        f"sensor of {column} drifts, {when} to {{}} of its range too much", whole * course.size, whole * course.error
    )
    drift = Suspect(
        f"{column}{DRIFT}", title, bias.probability * course.grows, whole * course.size, whole * course.error, False
    )  # fmt: skip
    both = [bias._replace(probability=bias.probability * (1.0 - course.grows)), drift]
    likely = sorted(both, key=lambda suspect: -suspect.probability)
    return (
        likely[0],
        *(s for s in sorted((likely[1], *suspects[1:]), key=lambda s: -s.probability) if s.probability >= ELSE),
    )


def _place(suspect: Suspect, directions: Sequence[Direction]) -> int:
    return next(k for k, d in enumerate(directions) if d.name == suspect.name)


class _Fit(NamedTuple):
    """Of each beginning an error of a shape: its size by now, how well that is known, and squares that it leaves."""

    size: np.ndarray
    known: np.ndarray
    left: np.ndarray


def _fit(shape: np.ndarray, pull: np.ndarray, information: np.ndarray) -> _Fit:
    known = np.maximum(shape**2 @ information, 1e-300)
    size = (shape @ pull) / known
    off = pull[None, :] - size[:, None] * shape * information[None, :]
    left = np.where(information > 0.0, off**2 / np.maximum(information, 1e-300), 0.0).sum(axis=1)
    return _Fit(size, known, left)
