"""How strong a joint is today: the factor of its rate, each way, as travel measured before a run shows it.

Oil that has not warmed up, a battery, a payload make a joint slower than it was when its model was learnt, or one way slower and the other
faster. What both ways have in common and what one has more than the other (its lean) each wander around the mean as an Ornstein-Uhlenbeck
process, and the travel over a window of rows differs from what they say by an error whose variance grows with the travel, of Student's
distribution, since soil may stop a joint at any time. A Kalman filter follows the two numbers from window to window.

How far they go, how long they last and how large the errors are is learnt from how stretches of a log differ (empirical Bayes): the numbers
with which their travel is most likely, each by a rate that was learnt without it. A few stretches that agree by chance do not say that a joint is never
weaker: spreads have the prior of Chung et al. (2013, Psychometrika 78), whose density rises from zero in proportion to them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.elementary import log
from polydraulic.networks.model.lags import JointStrength

WEAKEST, STRONGEST = 0.5, 2.0  # factors of a rate
_FREEDOM = 2.0  # degrees of freedom of errors
_MOVED = 1e-3  # of the joint's range: windows with less travel say nothing of its strength
_OUTLASTS = 5.0  # runs: the shortest memory
_EVALUATIONS = 2000


class StrengthNumbers(NamedTuple):
    """`JointStrength` as kernels read it."""

    spread: float
    lean: float
    kept: float  # share of a deviation that is left a window later
    noise: float
    rows: float  # of a window; 0 of a joint that is always as strong as in the mean


class Belief(NamedTuple):
    """What is believed of a joint: deviations of its strength from 1, and how unsure they are."""

    both: float
    lean: float
    var_both: float
    covariance: float
    var_lean: float


def strength_numbers(strength: JointStrength | None) -> StrengthNumbers:
    """What kernels read of a model's strength."""
    if strength is None:
        return StrengthNumbers(0.0, 0.0, 0.0, 0.0, 0.0)
    kept = float(np.exp(-strength.rows / strength.memory))
    return StrengthNumbers(strength.spread, strength.lean, kept, strength.noise, float(strength.rows))


@kernel
def belief_variance(belief: Belief, net: float, path: float) -> float:
    """Of the travel that deviations add to a window: its rates add up to `net`, their sizes to `path`."""
    both, lean = net * net * belief.var_both, path * path * belief.var_lean
    return both + lean + 2.0 * net * path * belief.covariance


@kernel
def after_window(belief: Belief, numbers: StrengthNumbers, net: float, path: float, travel: float) -> Belief:
    """The belief a window later; one in which the joint hardly moved lets time pass and no more."""
    both, lean = belief.both, belief.lean
    var_both, covariance, var_lean = belief.var_both, belief.covariance, belief.var_lean
    if path > numbers.noise:
        error = travel - net - both * net - lean * path
        unsure, noise = belief_variance(belief, net, path), numbers.noise * path
        # errors far out have a larger variance by themselves
        noise *= max(1.0, (_FREEDOM + error * error / (unsure + noise)) / (_FREEDOM + 1.0))
        of_both = (var_both * net + covariance * path) / (unsure + noise)
        of_lean = (covariance * net + var_lean * path) / (unsure + noise)
        both, lean = both + of_both * error, lean + of_lean * error
        var_both = max(0.0, var_both - of_both * of_both * (unsure + noise))
        var_lean = max(0.0, var_lean - of_lean * of_lean * (unsure + noise))
        covariance -= of_both * of_lean * (unsure + noise)
    kept, new = numbers.kept, 1.0 - numbers.kept * numbers.kept
    return Belief(
        kept * both,
        kept * lean,
        kept * kept * var_both + new * numbers.spread * numbers.spread,
        kept * kept * covariance,
        kept * kept * var_lean + new * numbers.lean * numbers.lean,
    )


@driver
def _surprise(numbers: StrengthNumbers, begins: np.ndarray, windows: np.ndarray, least: float) -> float:
    """Minus the logarithm of how likely the travel of windows is; columns of `windows`: net and path of rates, travel."""
    total = 0.0
    belief = Belief(0.0, 0.0, numbers.spread * numbers.spread, 0.0, numbers.lean * numbers.lean)
    for n in range(windows.shape[0]):
        if begins[n]:
            belief = Belief(0.0, 0.0, numbers.spread * numbers.spread, 0.0, numbers.lean * numbers.lean)
        net, path, travel = windows[n, 0], windows[n, 1], windows[n, 2]
        if path > least:
            error = travel - net - belief.both * net - belief.lean * path
            variance = belief_variance(belief, net, path) + numbers.noise * path
            total += 0.5 * log(variance)
            total += 0.5 * (_FREEDOM + 1.0) * log(1.0 + error * error / variance / _FREEDOM)
        belief = after_window(belief, numbers, net, path, travel)
    return total


def learn_strength(stretches: Sequence[np.ndarray], rows: int, horizon: int, size: float) -> JointStrength | None:
    """How the strength of a joint differs, from its travel in windows by rates that were learnt without them.

    Parameters
    ----------
    stretches : sequence of (n_window, 3) array
        Windows that follow each other: sum of the rates and of their sizes, and the travel measured; zeros where one says nothing.
    rows : int
        Of a window.
    horizon : int
        Rows of the runs that strengths are meant for: what does not outlast several of them is no strength.
    size : float
        The joint's range.

    Returns
    -------
    JointStrength or None
        None where no window says anything.
    """
    from scipy.optimize import minimize

    windows = np.vstack([np.zeros((0, 3)), *stretches])
    begins = np.concatenate([np.zeros(0, dtype=np.bool_), *(np.arange(len(one)) == 0 for one in stretches)])
    if not (windows[:, 1] > _MOVED * size).any():
        return None
    shortest, longest = _OUTLASTS * horizon, 1000.0 * _OUTLASTS * horizon
    low = np.log([1e-6 * size, 0.003, 0.003, shortest])
    high = np.log([0.25 * size, 0.5, 0.5, longest])

    def strength(unknowns: np.ndarray) -> JointStrength:
        noise, spread, lean, memory = np.exp(unknowns).tolist()
        return JointStrength(rows, spread, lean, memory, noise)

    def objective(unknowns: np.ndarray) -> float:
        numbers = strength_numbers(strength(unknowns))
        return float(_surprise(numbers, begins, windows, _MOVED * size)) - float(unknowns[1] + unknowns[2])

    starts = np.log([[1e-3 * size, 0.05, 0.05, 2.0 * shortest], [1e-3 * size, 0.1, 0.02, 20.0 * shortest]])
    tries = [
        minimize(
            objective,
            start,
            method="L-BFGS-B",
            bounds=list(zip(low, high, strict=True)),
            options={"maxfun": _EVALUATIONS},
        )
        for start in starts
    ]
    return strength(min(tries, key=lambda one: one.fun).x)


def windows_of(rates: np.ndarray, joint: np.ndarray, usable: np.ndarray, start: int, stop: int, rows: int) -> np.ndarray:  # fmt: skip
    """Windows of `rows` rows from `start` on, as `learn_strength` takes them; (n_window, 3).

    Parameters
    ----------
    rates, joint : (n_row,) array
        Rate of each row, which leads to its angle or stroke.
    usable : (n_row,) array of bool
        Rows in which the joint follows its valve; a window with another one is all zeros.
    start, stop : int
        There is a row before `start`.
    rows : int
    """
    firsts = np.arange(start, stop - rows + 1, rows)
    of = firsts[:, None] + np.arange(rows)
    travel = joint[firsts + rows - 1] - joint[firsts - 1]
    found = np.column_stack([rates[of].sum(axis=1), np.abs(rates[of]).sum(axis=1), travel])
    found[~(usable[of].all(axis=1) & usable[firsts - 1])] = 0.0
    return found
