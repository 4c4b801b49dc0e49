"""How the error of a sensor that an alarm is named by went on: it came at once and stays, a bias, or it grows, a drift.

Both are fitted to the blocks about the alarm's beginning. Either may have begun at any of some blocks; what speaks for it is averaged over these and
over its size, as for any other fault.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.elementary import exp, log
from polydraulic.watch.kernels.evidence import KEPT, ring_place
from polydraulic.watch.kernels.numbers import (
    BLOCKS,
    COURSE,
    FIRST,
    GROWN,
    GROWN_ERROR,
    GROWS,
    LISTED,
    OPENED,
    STUCK,
    SUSPECTS,
    TOLD,
    WatchNumbers,
)

BEFORE = 300  # blocks before an alarm seems to have begun, in which a drift may have
BEGINNINGS = 60  # blocks at which either may have begun that are tried
ROOM_OF_COURSE = 2 * KEPT + 4 * BEGINNINGS
_LEAST, _NEVER = 1e-300, -1e300
# What is known of a course; the last is one whose beginning is no longer kept.
NO_COURSE, SEEN_WHOLE, BEGAN_BEFORE = 0, 1, 2


class GrownError(NamedTuple):
    """Probability that an error grew evenly rather than came at once; of one that grew its size by now, and a standard error."""

    grows: float
    size: float
    error: float


@driver
def follow_course(numbers: WatchNumbers, work: np.ndarray, live: np.ndarray, marks: np.ndarray) -> None:
    """Find how the error went on that an alarm is named by, if it is one; of a beginning that is no longer kept, leave what was found."""
    count, first = marks[BLOCKS], marks[FIRST]
    if marks[TOLD] == count:
        marks[COURSE] = NO_COURSE
    if marks[STUCK] > 0:
        return
    place = numbers.group[marks[SUSPECTS]]
    if marks[LISTED] == 0 or numbers.errors[place] == 0:
        marks[COURSE] = NO_COURSE
        return
    # blocks in which another sensor stayed are left out
    begin = max(marks[OPENED] - BEFORE, 0) if first == marks[OPENED] else first
    if marks[COURSE] != NO_COURSE and begin < count - KEPT:
        marks[COURSE] = BEGAN_BEFORE
        return
    begin = max(begin, count - KEPT)
    n, at = count - begin, numbers.in_course
    of_block = 3 * numbers.directions
    totals = numbers.at_sums + of_block + place
    for k in range(n):
        before, here = totals + ring_place(begin + k) * of_block, totals + ring_place(begin + k + 1) * of_block
        work[at + k] = live[here] - live[before]
        work[at + n + k] = live[here + numbers.directions] - live[before + numbers.directions]
    course = course_of(work, at, n, numbers.together[place])
    marks[COURSE] = SEEN_WHOLE
    live[GROWS] = course.grows
    live[GROWN] = course.size
    live[GROWN_ERROR] = course.error


@driver
def course_of(seen: np.ndarray, at: int, n: int, together: float) -> GrownError:
    """The course of an error by n blocks: from `at` on stand the pull of each, the information of each, and room for what is tried.

    `together` is what evidence is divided by. Of each beginning an error that stays and one that grows are fitted, one behind the other, as sizes
    and how well these are known.
    """
    squares, counts = 0.0, 0
    for k in range(n):
        own = seen[at + n + k]
        squares += seen[at + k] * seen[at + k] / own if own > 0.0 else 0.0
        counts += 1 if own > 0.0 else 0
    fits = at + 2 * n
    tried = _fit_beginnings(seen, at, n, fits)
    explained = 0.0
    for k in range(tried):
        explained = max(explained, seen[fits + 2 * k] * seen[fits + 2 * k] * seen[fits + 2 * k + 1])
    scatter = max((squares - explained) / float(max(counts - 1, 1)), together)
    highest, most, best = _NEVER, _NEVER, 1
    for k in range(tried):
        speaks = _speaks(seen[fits + 2 * k], seen[fits + 2 * k + 1], scatter)
        highest = max(highest, speaks)
        better = k & 1 == 1 and speaks >= most
        best = k if better else best
        most = speaks if better else most
    stays, grows = 0.0, 0.0
    for k in range(tried):
        likely = exp(_speaks(seen[fits + 2 * k], seen[fits + 2 * k + 1], scatter) - highest)
        stays += 0.0 if k & 1 == 1 else likely
        grows += likely if k & 1 == 1 else 0.0
    return GrownError(grows / (stays + grows), seen[fits + 2 * best], sqrt(scatter / seen[fits + 2 * best + 1]))


@driver
def _fit_beginnings(seen: np.ndarray, at: int, n: int, fits: int) -> int:
    """Fill sizes, and how well they are known, for beginnings from the last block back to the first; how many fits there are.

    From one block to the one before it, what has stayed is seen in one block more, and what has grown is larger by what has stayed: sums need no block
    twice. A block that tells nothing pulls nothing.
    """
    pull, known, grown_pull, grown_once, grown_known = 0.0, 0.0, 0.0, 0.0, 0.0
    count, first = 0, n
    for turn in range(BEGINNINGS):
        after = first
        share = float(n - 1) / float(BEGINNINGS - 1)
        first = n - 1 if turn == 0 else int(float(BEGINNINGS - 1 - turn) * share)
        for back in range(after - first):
            own = seen[at + n + after - 1 - back]
            pull += seen[at + after - 1 - back] if own > 0.0 else 0.0
            known += own
            grown_pull += pull
            grown_known += 2.0 * grown_once + known
            grown_once += known
        if first < after:
            whole, place = float(n - first), fits + 2 * count
            seen[place + 1] = max(known, _LEAST)
            seen[place] = pull / seen[place + 1]
            seen[place + 3] = max(grown_known / (whole * whole), _LEAST)
            seen[place + 2] = grown_pull / whole / seen[place + 3]
            count += 2
    return count


@kernel
def _speaks(size: float, known: float, scatter: float) -> float:
    """What speaks for an error, averaged over its size."""
    return 0.5 * (size * size * known / scatter - log(1.0 + known / scatter))
