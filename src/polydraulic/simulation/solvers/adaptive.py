"""Coefficients of the Rosenbrock method, and bounds of how it chooses its steps."""

from typing import NamedTuple

import numpy as np

MAX_STEPS = 2_000_000
DONE, TOO_FAST, TOO_SMALL, TOO_MANY = 0, 1, 2, 3  # how a run has ended
FAILURES = {
    TOO_FAST: "diverged, a joint's rate grew without bound",
    TOO_SMALL: "steps became too small, or events too many at one time",
    TOO_MANY: f"more than {MAX_STEPS} steps",
}
MANY_AT_ONCE = 20  # events without progress
SMALLEST_STEP = 1e-10  # s


class Tableau(NamedTuple):
    """Coefficients in the form without matrix-vector products: (1 / (gamma h) - J) U_i = f(y + sum a U) + sum (c / h) U + d h f_t.

    The last row of `a`, with 1 for the last stage, gives the new state, and the last stage is the error.
    """

    gamma: float
    a: np.ndarray  # (n_stage, n_stage)
    c: np.ndarray  # (n_stage, n_stage)
    time: np.ndarray  # (n_stage,)
    d: np.ndarray  # (n_stage,)


def _lower(*rows: tuple[float, ...]) -> np.ndarray:
    full = np.zeros((len(rows) + 1, len(rows) + 1))
    for i, row in enumerate(rows):
        full[i + 1, : len(row)] = row
    return full


_FIFTH = (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950)
RODAS = Tableau(
    gamma=0.25,
    a=_lower(
        (1.544,),
        (0.9466785280815826, 0.2557011698983284),
        (3.314825187068521, 2.896124015972201, 0.9986419139977817),
        _FIFTH,
        (*_FIFTH, 1.0),
    ),
    c=_lower(
        (-5.6688,),
        (-2.430093356833875, -0.2063599157091915),
        (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
        (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
        (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
    ),
    time=np.array([0.0, 0.386, 0.21, 0.63, 1.0, 1.0]),
    d=np.array([0.25, -0.1043, 0.1035, -0.0362000000000023, 0.0, 0.0]),
)
