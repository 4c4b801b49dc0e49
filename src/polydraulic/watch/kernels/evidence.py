"""Evidence of all tests, block by block: sums that begin anew where they are negative; and which direction alone explains it best.

`live` holds evidence one behind the other: sums of both ways of each direction (up, down), what the smallest faults would have shown, rows of
pull, information and squares of pull over information of all directions, summed up since the first block, the last `KEPT` + 1 of them in a ring,
and the information of each sum since it began.

What is expected strays slowly: over blocks with information I the sum of pull has the variance t I + s I^2, with s that of the offset from one
stretch to the next. Evidence is divided by that over I, so that it comes to an end where a fault is no larger than what strays. I counts up to
`REMEMBERED` t / s: the end is nearly reached then, and a fault that begins later need not make up for hours of straying before it.
"""

import numpy as np

from polydraulic._kernel import driver
from polydraulic.elementary import exp, log
from polydraulic.watch.kernels.numbers import MOST_LISTED

KEPT = 600  # blocks back to which a beginning can lie
LEAST_BLOCKS = 8  # that decide together
_MOST = 2.0  # thresholds that a sum may reach
ELSE = 0.02  # probability from which on another fault is named
REMEMBERED = 9.0  # times s I at which a sum's information counts at most; see above
_NEVER = -1e300


def room_of_evidence(n: int) -> int:
    """Numbers that evidence of n directions takes."""
    return 3 * n + 3 * n * (KEPT + 1) + 2 * n


@driver
def ring_place(block: int) -> int:
    """Place of a block among those that are kept; the first of all blocks has the place 0."""
    return block - (KEPT + 1) * int(float(block) / float(KEPT + 1))


@driver
def gather(
    white: np.ndarray,
    at_white: int,
    together: np.ndarray,
    slow: np.ndarray,
    down: np.ndarray,
    threshold: float,
    count: int,
    live: np.ndarray,
    at_sums: int,
    began: np.ndarray,
    at_began: int,
) -> None:
    """Take a block's whitened scores, pull and then information of all directions.

    `count` is the number of blocks with this one; `together` is what evidence is divided by, `slow` the variance of offsets that stray, `down` is
    1 of directions that go both ways.
    """
    n = together.shape[0]
    most = threshold / float(LEAST_BLOCKS)
    showing, totals = at_sums + 2 * n, at_sums + 3 * n
    since = totals + 3 * n * (KEPT + 1)
    before = totals + ring_place(count - 1) * 3 * n
    here = totals + ring_place(count) * 3 * n
    for k in range(n):
        own, known = white[at_white + k], white[at_white + n + k]
        for way in range(2):
            place = 2 * k + way
            gained = ((own if way == 0 else -own) - 0.5 * known) / together[k]
            # a block that counts for less than it says counts for as much less of its information
            seen = live[since + place] + known * min(most / max(abs(gained), 1e-300), 1.0)
            wide = 1.0 + slow[k] * live[since + place] / together[k]
            total = live[at_sums + place] * wide + min(max(gained, -most), most)
            fresh = total <= 0.0
            goes = way == 0 or down[k] != 0
            total = total / (1.0 + slow[k] * seen / together[k])
            live[at_sums + place] = 0.0 if fresh or not goes else min(total, _MOST * threshold)
            live[since + place] = 0.0 if fresh else min(seen, REMEMBERED * together[k] / max(slow[k], 1e-300))
            began[at_began + place] = count if fresh else began[at_began + place]
        shown = live[showing + k] / (1.0 - 2.0 * slow[k] * live[showing + k]) + min(0.5 * known / together[k], most)
        live[showing + k] = shown / (1.0 + 2.0 * slow[k] * shown)
        square = own * own / max(known, 1e-300) if known > 0.0 else 0.0
        live[here + k] = live[before + k] + own
        live[here + n + k] = live[before + n + k] + known
        live[here + 2 * n + k] = live[before + 2 * n + k] + square


@driver
def sum_since(live: np.ndarray, at_sums: int, n: int, first: int, count: int, seen: np.ndarray, at_seen: int) -> None:
    """What was seen of all directions from after a block on: pull, information, squares."""
    totals = at_sums + 3 * n
    here, before = totals + ring_place(count) * 3 * n, totals + ring_place(first) * 3 * n
    for k in range(3 * n):
        seen[at_seen + k] = live[here + k] - live[before + k]


@driver
def best_evidence(pull: float, information: float, together: float, down: int) -> float:
    """Logarithm of the likelihood ratio of a direction in the size that fits best; very negative where that would go the wrong way."""
    allowed = information > 0.0 and (down != 0 or pull > 0.0)
    return 0.5 * pull * pull / max(information, 1e-300) / together if allowed else _NEVER


@driver
def diagnose(
    seen: np.ndarray,
    at_seen: int,
    n: int,
    together: float,
    down: np.ndarray,
    group: np.ndarray,
    chances: np.ndarray,
    at_chances: int,
    listed: np.ndarray,
    at_listed: int,
) -> int:
    """Fill the probability of each direction, one of them alone, and list those that may be meant; how many.

    Directions of one group are sizes of one fault, and listed once.
    """
    best = _NEVER
    for k in range(n):
        pull, information = seen[at_seen + k], seen[at_seen + n + k]
        # of a size that is free
        evidence = best_evidence(pull, information, together, down[k]) - 0.5 * log(1.0 + information / together)
        chances[at_chances + k] = evidence
        best = max(best, evidence)
    total = 0.0
    for k in range(n):
        chances[at_chances + k] = exp(chances[at_chances + k] - best) if best > 0.0 else 0.0
        total += chances[at_chances + k]
    for k in range(n):
        chances[at_chances + k] = chances[at_chances + k] / max(total, 1e-300)
    count = 0
    for turn in range(MOST_LISTED):
        found, most = -1, 0.0
        for k in range(n):
            new = chances[at_chances + k] > most
            for other in range(turn):
                new = new and group[listed[at_listed + other]] != group[k]
            found = k if new else found
            most = chances[at_chances + k] if new else most
        if found < 0 or (turn > 0 and most < ELSE):
            break
        listed[at_listed + turn] = found
        count = turn + 1
    for _ in range(count):
        for k in range(count - 1):
            here, after = listed[at_listed + k], listed[at_listed + k + 1]
            if _together(chances, at_chances, n, group, after) > _together(chances, at_chances, n, group, here):
                listed[at_listed + k] = after
                listed[at_listed + k + 1] = here
    return count


@driver
def _together(chances: np.ndarray, at_chances: int, n: int, group: np.ndarray, of: int) -> float:
    """Probability of all sizes of a fault."""
    total = 0.0
    for k in range(n):
        total += chances[at_chances + k] if group[k] == group[of] else 0.0
    return total
