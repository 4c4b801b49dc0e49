"""Trajectories side by side: errors by column, and of the end-effector."""

from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.tables import Table


class Difference(NamedTuple):
    """How far one column of a run is from the reference, in the column's unit."""

    unit: str
    largest: float  # with its sign
    time: float  # s, when it was largest
    rms: float
    final: float


def compare(reference: Table, model: Table) -> dict[str, Difference]:
    """Differences model - reference, for every column that both have.

    Parameters
    ----------
    reference, model : Table
        Runs with the same times.

    Returns
    -------
    dict from column to Difference
        ``effector.distance`` is how far apart the two end-effectors are, in m, never negative.

    Raises
    ------
    InputError
        If the two do not have the same times.
    """
    t = reference["time"]
    if len(t) != len(model) or not np.allclose(t, model["time"], rtol=0.0, atol=1e-9):
        raise InputError(f"the runs have different times: {len(t)} and {len(model)} rows; simulate both alike")
    found = {}
    for name in reference.names:
        if name in model.columns and name != "time":
            found[name] = _difference(reference.unit(name), t, model[name] - reference[name])
    if set(EFFECTOR) <= set(found):
        found["effector.distance"] = _difference("m", t, effector_distance(reference, model))
    return found


def effector_distance(reference: Table, model: Table) -> np.ndarray:
    """Distance in m between the end-effectors of two runs with the same times, (n_time,)."""
    return np.asarray(np.linalg.norm(model.matrix(EFFECTOR) - reference.matrix(EFFECTOR), axis=1))


def _difference(unit: str, t: np.ndarray, error: np.ndarray) -> Difference:
    k = int(np.argmax(np.abs(error)))
    return Difference(unit, float(error[k]), float(t[k]), float(np.sqrt(np.mean(error * error))), float(error[-1]))
