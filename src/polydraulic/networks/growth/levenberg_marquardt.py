"""Levenberg-Marquardt: Gauss-Newton steps, damped as much as it takes for the loss to fall."""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv


class Equations(NamedTuple):
    """Gauss-Newton equations at one point, its loss, and the squared error in it without any penalty."""

    gram: np.ndarray
    gradient: np.ndarray  # half of it
    loss: float
    error: float


class Damping(NamedTuple):
    """How steps are damped, and when to stop.

    Attributes
    ----------
    largest, smallest : float
        With more the search ends; there is never less.
    raise_by, raise_more : float
        Factor after a step that fails, and the factor by which that grows with each failure after another.
    lower : function (share) -> factor
        After a step that lowers the loss by this share of what the linear model promised.
    least_relative, least_added : float
        Lower bound of a diagonal element, as a part of the largest one; what is added to each whatever the damping.
    enough, last_steps : float, int
        After this many steps in a row that lower the loss by a smaller share, the search ends.
    perfect : float
        A loss at which it ends, too.
    """

    largest: float
    raise_by: float
    lower: Callable[[float], float]
    enough: float
    raise_more: float = 1.0
    smallest: float = 0.0
    least_relative: float = 0.0
    least_added: float = 0.0
    last_steps: int = 1
    perfect: float = 0.0


FIRST_DAMPING = 1e-3


class Descent(NamedTuple):
    """How far a search has come after a step, besides where it is: what it goes on from as if nothing had stopped it.

    Attributes
    ----------
    damping : float
    attempts, steps : int
        Evaluations, and steps that lowered the loss.
    slow : int
        Of these the last ones in a row that lowered it little.
    """

    damping: float = FIRST_DAMPING
    attempts: int = 0
    steps: int = 0
    slow: int = 0


def lower_loss(
    start: np.ndarray,
    here: Equations,
    evaluate: Callable[[np.ndarray, float], Equations | None],
    rules: Damping,
    *,
    max_attempts: float = inf,
    max_steps: float = inf,
    watch: Callable[[int, float], None] = lambda attempt, loss: None,
    begun: Descent = Descent(),  # noqa: B008 - a tuple never changes
    keep: Callable[[Descent], object] = lambda reached: None,
) -> tuple[np.ndarray, Equations]:
    """Lower a sum of squares.

    Parameters
    ----------
    start : (n,) array
    here : Equations
        At the start.
    evaluate : function (coef, limit) -> Equations or None
        None where the loss is not below the limit, or no number. Slopes without bound end the search where it is.
    rules : Damping
    max_attempts, max_steps : float
        Evaluations, and steps that lower the loss, at most, with those of `begun`.
    watch : function (attempt, loss)
        Called after each step.
    begun : Descent
        How far the search had come that goes on here.
    keep : function (Descent)
        Called after each step, too.

    Returns
    -------
    coef : (n,) array
    here : Equations
        There.
    """
    coef, raise_by = start, rules.raise_by
    damping, attempt, steps, slow = begun
    while attempt < max_attempts and steps < max_steps and slow != rules.last_steps:
        step, promised = _step(here, damping, rules)
        there = evaluate(coef - step, here.loss) if promised > 0.0 else None
        attempt += 1
        if there is None:
            damping, raise_by = damping * raise_by, raise_by * rules.raise_more
            if damping > rules.largest:
                break
            continue
        if not np.isfinite(there.gram).all():
            break
        gained = here.loss - there.loss
        damping, raise_by = max(damping * rules.lower(gained / promised), rules.smallest), rules.raise_by
        slow = slow + 1 if gained < rules.enough * here.loss else 0
        coef, here, steps = coef - step, there, steps + 1
        watch(attempt - 1, here.loss)
        keep(Descent(damping, attempt, steps, slow))
        if here.loss <= rules.perfect:
            break
    return coef, here


def _step(here: Equations, damping: float, rules: Damping) -> tuple[np.ndarray, float]:
    """Step against the gradient, and what it would lower the loss by if all were linear; 0 if there is none."""
    diagonal = np.diagonal(here.gram)
    added = damping * np.maximum(diagonal, rules.least_relative * diagonal.max()) + rules.least_added
    matrix = np.array(here.gram, order="F")
    matrix[np.diag_indices_from(matrix)] += added
    _, step, failed = dposv(matrix, here.gradient, overwrite_a=True)
    if failed:
        return here.gradient, 0.0
    promised = float(step @ (added * step + here.gradient))
    return step, promised if np.isfinite(promised) else 0.0
