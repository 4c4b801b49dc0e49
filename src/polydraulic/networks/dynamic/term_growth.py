"""Growth of polynomials of lagged signals, term by term, each the one that most improves how they run on their own.

Terms that look good one step ahead may run badly: noise on measured outputs is taken for damping, and slow errors hardly show.
So a term is judged by what it would do to runs over a horizon (to first order, all other coefficients moving with it), and
after each one all coefficients are refined over the same runs. Terms are those of the nodes of a network.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.linalg import LinAlgError, solve_triangular

from polydraulic.networks.dynamic.free_run import pieces
from polydraulic.networks.dynamic.lagged_terms import Frame, Terms, averaged, run_side_by_side
from polydraulic.networks.dynamic.spans import Span, blocks_of, without
from polydraulic.networks.growth.levenberg_marquardt import Damping, Equations, lower_loss
from polydraulic.networks.growth.workers import in_threads

_RIDGE = 0.01  # weight of the sum of squared coefficients, as a part of the error before, all in normalized units
_STEPS = 3  # of refinement after each term
# a step that lowers the loss by less than a thousandth of what is left is the last
_RULES = Damping(largest=1e3, raise_by=6.0, lower=lambda share: 0.2, least_added=1e-12, enough=1e-3 / (1.0 + 1e-3))
_REFINE_ROWS, _JUDGE_ROWS = 8_000, 2_000  # that are looked at, in windows spread evenly
_ROWS_A_TERM = 5  # at least
_ALL_PAIRS = 40  # lagged values at most, of which any two may be multiplied
_MEMBERS = 8  # of an average
_NEW = 1e-6  # share of a term that others do not explain: less is rounding
_EXACT = 1e-12  # mean squared error at which there is nothing left to learn


def grow_terms(frame: Frame, spans: Sequence[Span], horizon: int, *, all_pairs: int = _ALL_PAIRS) -> Iterator[Terms]:
    """Polynomials of one term more at a time, as long as there is something to add and rows to learn it from.

    Parameters
    ----------
    frame : Frame
    spans : sequence of (start, stop)
        Rows to learn from.
    horizon : int
        Rows that runs go on before they restart from measured outputs.
    all_pairs : int
        Lagged values at most, of which any two may be multiplied.
    """
    windows = np.array(pieces(spans, horizon), dtype=np.int64)
    many, few = _spread_evenly(windows, _REFINE_ROWS), _spread_evenly(windows, _JUDGE_ROWS)
    terms, error = _refined(frame, _held(frame), many, _RIDGE)
    most = sum(b - a for a, b in spans) * len(frame.y_low) // _ROWS_A_TERM
    yield terms
    while len(terms.coef) < most:
        more = _best_term(frame, terms, few, all_pairs) if error > _EXACT else None
        if more is None:
            return
        terms, error = _refined(frame, more, many, _RIDGE * error)
        yield terms


def grow_average(frame: Frame, spans: Sequence[Span], horizon: int, n_term: int) -> Terms:
    """Grow polynomials of this many terms, each without another part of the rows, and average them.

    Which terms are chosen, and so how a run ends, hangs on a few rows; the average hangs on them less. One that runs badly through
    all rows counts little.

    Parameters
    ----------
    frame : Frame
    spans : sequence of (start, stop)
        Rows to learn from.
    horizon : int
    n_term : int
        Of each polynomial at most.
    """

    def without_block(left_out: list[Span]) -> tuple[Terms, float]:
        rest = without(spans, left_out) or spans
        for member in grow_terms(frame, rest, horizon):
            if len(member.coef) >= n_term:
                break
        return member, 1.0 / (1e-12 + _loss(frame, member, np.array(spans)))

    members, weights = zip(*in_threads(without_block, blocks_of(spans, _MEMBERS)), strict=True)
    return averaged(members, np.array(weights))


def _held(frame: Frame) -> Terms:
    """The last value of each output and a constant, where growth begins."""
    n_output, factors, output, coef = len(frame.y_low), [], [], []
    for k in range(n_output):
        own = np.flatnonzero(frame.column == frame.signals.shape[1] - n_output + k)
        latest = [1 + int(own[np.argmin(frame.steps[own])])] if own.size else []
        factors += [[place, 0, 0] for place in (0, *latest)]
        output += [k] * (1 + len(latest))
        # a run that holds forever has no slopes to go by
        coef += [1e-6, *([0.98] * len(latest))]
    return Terms(np.array(factors, dtype=np.int64), np.array(output, dtype=np.int64), np.array(coef))


def _candidates(terms: Terms, n_lag: int, all_pairs: int) -> tuple[np.ndarray, np.ndarray]:
    """Terms that may be added: powers, products of two values, and of three where the product of two of them is there.

    With many lagged values one of two has to be in the polynomial, too, since there are too many pairs.
    """
    factors, output = [], []
    places = range(1, n_lag + 1)
    powers = {(a, *power) for a in places for power in ((0, 0), (a, 0), (a, a))}
    for k in np.unique(terms.output):
        there = {tuple(one) for one in terms.factors[terms.output == k].tolist()}
        partners = places if n_lag <= all_pairs else {a for one in there for a in one if a}
        pairs = {(max(a, b), min(a, b), 0) for a in partners for b in places if a != b}
        grown = [(a, b) for a, b, d in there if d == 0 and b > 0 and a != b]
        triples = {tuple(sorted((a, b, c), reverse=True)) for a, b in grown for c in places if c not in (a, b)}
        new = sorted((powers | pairs | triples) - there)
        factors += new
        output += [k] * len(new)
    return np.array(factors, dtype=np.int64).reshape(-1, 3), np.array(output, dtype=np.int64)


def _best_term(frame: Frame, terms: Terms, windows: np.ndarray, all_pairs: int) -> Terms | None:
    """Terms with the candidate that lowers the squared error most; None if none does."""
    candidates = _candidates(terms, len(frame.column), all_pairs)
    n, wider = len(terms.coef), terms.and_also(*candidates)
    gram, cross, size = np.zeros((n, n)), np.zeros((n, len(candidates[1]))), np.zeros(len(candidates[1]))
    downhill = np.zeros(len(wider.coef))
    for errors, every in run_side_by_side(frame, wider, windows):
        slopes = every.reshape(n + len(size), -1)
        own, new = slopes[:n], slopes[n:]
        gram += own @ own.T
        cross += own @ new.T
        size += np.einsum("ij,ij->i", new, new)
        downhill += slopes @ errors.ravel()
    try:
        root = np.linalg.cholesky(gram + 1e-9 * np.diag(np.diagonal(gram) + 1e-300))
    except LinAlgError:
        return None
    explained = solve_triangular(root, cross, lower=True)
    left = size - np.einsum("ij,ij->j", explained, explained)
    across = downhill[n:] - solve_triangular(root, downhill[:n], lower=True) @ explained
    gain = np.where(left > _NEW * size, across**2 / np.where(left > 0.0, left, 1.0), 0.0)
    if not gain.size or not gain.max() > 0.0:
        return None
    best = [int(np.argmax(gain))]
    return terms.and_also(candidates[0][best], candidates[1][best])


def _refined(frame: Frame, terms: Terms, windows: np.ndarray, weight: float) -> tuple[Terms, float]:
    """Terms with better coefficients (a few steps of Levenberg-Marquardt), and the mean squared error of runs.

    `weight` is that of the squares of the coefficients.
    """
    ridge = np.full(len(terms.coef), weight)

    def evaluate(coef: np.ndarray, limit: float) -> Equations | None:
        here = terms._replace(coef=coef)
        near = _loss(frame, here, windows) + ridge @ coef**2 < limit  # runs without slopes cost little
        return _normal_equations(frame, here, windows, ridge) if near else None

    here = _normal_equations(frame, terms, windows, ridge)
    coef, there = lower_loss(terms.coef, here, evaluate, _RULES, max_steps=_STEPS)
    return terms._replace(coef=coef), there.error


def _normal_equations(frame: Frame, terms: Terms, windows: np.ndarray, ridge: np.ndarray) -> Equations:
    n = len(terms.coef)
    gram, gradient, squares, count = np.zeros((n, n)), np.zeros(n), 0.0, _n_answer(frame, windows)
    for errors, every in run_side_by_side(frame, terms, windows):
        slopes, flat = every.reshape(n, -1), errors.ravel()
        gram += slopes @ slopes.T
        gradient += slopes @ flat
        squares += float(flat @ flat)
    coef, error = terms.coef, squares / count
    return Equations(
        gram / count + np.diag(ridge), gradient / count + ridge * coef, error + float(ridge @ coef**2), error
    )


def _loss(frame: Frame, terms: Terms, windows: np.ndarray) -> float:
    errors = (part.ravel() for part, _ in run_side_by_side(frame, terms, windows, slopes=False))
    return sum(float(part @ part) for part in errors) / _n_answer(frame, windows)


def _n_answer(frame: Frame, windows: np.ndarray) -> int:
    """Answers in all windows: one for each output of a row."""
    return int((windows[:, 1] - windows[:, 0]).sum()) * len(frame.y_low)


def _spread_evenly(windows: np.ndarray, n_row: int) -> np.ndarray:
    """As many windows as hold this many rows, at least one."""
    kept = max(1, int(n_row / np.mean(windows[:, 1] - windows[:, 0])))
    return windows if kept >= len(windows) else windows[np.linspace(0, len(windows) - 1, kept).astype(int)]
