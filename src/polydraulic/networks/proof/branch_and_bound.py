"""Branch and bound: proved ranges of several quantities over a box, from enclosures over many sub-boxes at once.

Sub-boxes whose enclosure reaches out of a goal are halved, the furthest first. The goal may be a fixed range, or one close
to the values found so far. What is returned is proved whether or not the goal is met.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

_BATCH = 256  # boxes halved at a time
_ROUNDING = 1e-12  # of the largest value: a gap that is not worth another box


class Ends(NamedTuple):
    """T quantities over m boxes of n inputs; without the axis m, over the whole box."""

    low: np.ndarray  # (T, m) proved
    high: np.ndarray
    inner_low: np.ndarray  # (T, m) the least is no higher than this, by a value found; inf if none was
    inner_high: np.ndarray
    at_low: np.ndarray  # (T, n, m) where it was found
    at_high: np.ndarray


Enclose = Callable[[np.ndarray, np.ndarray], Ends]
# From inner_low and inner_high (T,) to the range that every sub-box must keep.
Goal = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray | float, np.ndarray | float]]


def close_to_found(tolerance: float) -> Goal:
    """Goal: what has been found, and a part of its width on both sides."""

    def goal(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        allowed = tolerance * np.maximum(high - low, 0.0) + _ROUNDING * np.maximum(np.abs(low), np.abs(high))
        return low - allowed, high + allowed

    return goal


def search(enclose: Enclose, box: np.ndarray, goal: Goal, max_boxes: int) -> tuple[Ends, int, bool]:
    """Enclose ever smaller sub-boxes until all keep the goal.

    Parameters
    ----------
    enclose : function of the lows and highs (n, m) of m boxes
    box : (n, 2) array
    goal : function of what has been found
    max_boxes : int
        Enclosures at most.

    Returns
    -------
    ends : Ends
    n_boxes : int
        Enclosures made.
    converged : bool
        False if the budget is used, a box too small to be halved does not keep the goal, or a value that was found does
        not; the last ends the search at once.
    """
    with np.errstate(all="ignore"):  # infinite and NaN enclosures are bounds too
        low, high = box[:, :1], box[:, 1:]
        side = np.where(high > low, high - low, 1.0)
        new = enclose(low, high)
        found = Ends(*(part[..., 0] for part in new))
        proved = np.array([new.low, new.high])
        settled = np.array([np.full_like(found.low, np.inf), np.full_like(found.low, -np.inf)])
        n_boxes, stuck = 1, False
        while True:
            reach, missed = _reach(proved, found, goal(found.inner_low, found.inner_high))
            waits = (reach > 0.0) & _can_be_halved(low, high, side)
            stuck = stuck or bool(np.any((reach > 0.0) & ~waits))
            settled = _hull(settled, proved[..., ~waits])
            low, high, proved, reach = low[:, waits], high[:, waits], proved[..., waits], reach[waits]
            n_halved = min(_BATCH, reach.size, (max_boxes - n_boxes) // 2)
            if missed or n_halved <= 0:
                break
            order = np.argsort(-reach, kind="stable")
            chosen, rest = order[:n_halved], order[n_halved:]
            new_low, new_high = _halves(low[:, chosen], high[:, chosen], side)
            new = enclose(new_low, new_high)
            n_boxes += 2 * n_halved
            found = _better(found, new)
            parent = np.tile(proved[..., chosen], 2)
            new_proved = np.array([np.maximum(new.low, parent[0]), np.minimum(new.high, parent[1])])
            low, high = np.hstack([low[:, rest], new_low]), np.hstack([high[:, rest], new_high])
            proved = np.concatenate([proved[..., rest], new_proved], axis=-1)
        whole = _hull(settled, proved)
    return found._replace(low=whole[0], high=whole[1]), n_boxes, not (stuck or missed or reach.size)


def _reach(
    proved: np.ndarray, found: Ends, goal: tuple[np.ndarray | float, np.ndarray | float]
) -> tuple[np.ndarray, bool]:
    """How far each box reaches out of the goal, in widths of what was found; and whether a found value does."""
    goal_low, goal_high = (np.broadcast_to(end, found.low.shape) for end in goal)
    missed = np.any(found.inner_low < goal_low) or np.any(found.inner_high > goal_high)
    width = found.inner_high - found.inner_low
    width = np.where((width > 0.0) & np.isfinite(width), width, 1.0)
    out = np.fmax(goal_low[:, None] - proved[0], proved[1] - goal_high[:, None]) / width[:, None]
    return np.where(np.isnan(out), np.inf, out).max(axis=0), bool(missed)


def _longest(low: np.ndarray, high: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The side of each box that is longest compared with that of the whole box, as an index into (n, m)."""
    return np.argmax((high - low) / side, axis=0), np.arange(low.shape[1])


def _can_be_halved(low: np.ndarray, high: np.ndarray, side: np.ndarray) -> np.ndarray:
    if not low.size:
        return np.zeros(low.shape[1], dtype=bool)
    at = _longest(low, high, side)
    middle = 0.5 * low[at] + 0.5 * high[at]
    return (low[at] < middle) & (middle < high[at])


def _halves(low: np.ndarray, high: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All lower halves and then all upper ones."""
    axis, box = _longest(low, high, side)
    middle = 0.5 * low[axis, box] + 0.5 * high[axis, box]
    new_low, new_high = np.tile(low, 2), np.tile(high, 2)
    new_high[axis, box] = middle
    new_low[axis, box + box.size] = middle
    return new_low, new_high


def _hull(one: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Hull of a range (2, T) and of others (2, T, m)."""
    low = np.minimum(one[0], np.min(others[0], axis=-1, initial=np.inf))
    return np.array([low, np.maximum(one[1], np.max(others[1], axis=-1, initial=-np.inf))])


def _better(found: Ends, new: Ends) -> Ends:
    """The found ends, moved where a new box has a lower or higher one."""
    rows = np.arange(found.low.size)
    lowest, highest = np.argmin(new.inner_low, axis=1), np.argmax(new.inner_high, axis=1)
    lower = new.inner_low[rows, lowest] < found.inner_low
    higher = new.inner_high[rows, highest] > found.inner_high
    return found._replace(
        inner_low=np.where(lower, new.inner_low[rows, lowest], found.inner_low),
        inner_high=np.where(higher, new.inner_high[rows, highest], found.inner_high),
        at_low=np.where(lower[:, None], new.at_low[rows, :, lowest], found.at_low),
        at_high=np.where(higher[:, None], new.at_high[rows, :, highest], found.at_high),
    )
