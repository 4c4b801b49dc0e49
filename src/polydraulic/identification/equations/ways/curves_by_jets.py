"""Curves that spools say more of than flows do: the jets of an orifice push its spool back, the more the narrower it is.

Where a valve is wide open, the pump's whole flow goes through it whatever its conductance is, so that flows hardly tell it; its spool does.
"""

import numpy as np

from polydraulic.identification.equations.circuits import ValveFound
from polydraulic.identification.equations.fit.jets import JET_CURVES


def jet_shares(v: ValveFound) -> np.ndarray:
    """Standard errors of a valve's curves at their knots as shares of them, of one at most, (n_number,); 0 where nothing is known of them."""
    parts = [
        np.minimum(np.nan_to_num(v.errors[key]) / np.maximum(getattr(v.curves, key), 1e-300), 1.0) for key in JET_CURVES
    ]
    return np.concatenate(parts)


def none_moved(v: ValveFound) -> np.ndarray:
    """That none of these curves is off, (n_number,)."""
    return np.zeros(len(JET_CURVES) * len(v.curves.knots))


def moved_by_jets(v: ValveFound, moved: np.ndarray, errors: np.ndarray) -> ValveFound:
    """A valve whose curves are off by so many standard errors, as jets of its spool say.

    Parameters
    ----------
    v : ValveFound
        As flows have it.
    moved, errors : (n_number,) array
        In shares of `jet_shares`: of a logarithm, since no conductance is negative.
    """
    m = len(v.curves.knots)
    inside = np.array(v.curves.knots) <= v.seen[1] + 1e-9
    last = int(np.flatnonzero(inside)[-1])
    shares, curves, sure = jet_shares(v), {}, dict(v.errors)
    for k, key in enumerate(JET_CURVES):
        part = slice(k * m, (k + 1) * m)
        factor = np.exp(shares[part] * moved[part])
        factor[last:] = factor[last]  # beyond what was seen, the curve keeps its shape
        values = np.maximum.accumulate(np.array(getattr(v.curves, key)) * factor)
        curves[key] = tuple(values.tolist())
        sure[key] = np.where(shares[part] > 0.0, values * shares[part] * errors[part], v.errors[key])
    return v._replace(curves=v.curves._replace(**curves), errors=sure)
