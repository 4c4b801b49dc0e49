"""A spool that a pilot drives by a random operator's lever, as it is and as a sensor reads it, in two segments."""

import numpy as np

from polydraulic import random_operator
from polydraulic.identification.equations.spool_motion import driven_spool, pieces_of
from polydraulic.parameters.schema import Pilot

TRUE = Pilot(0.014, 0.2, 0.06)
TRAVEL, RASTER = 0.0143, 0.02


def spool_log():
    """Time, segment, voltage, spool as it is and as it is read."""
    time = np.arange(6000) * RASTER
    segment = (time > 70.0).astype(int)
    voltage = np.ascontiguousarray(random_operator(3, 130.0, limit=1.1).voltages(time)[:, 1])
    exact = driven_spool(TRUE, TRAVEL, time, pieces_of(np.zeros(len(time))), voltage, np.zeros(len(time)), RASTER)
    measured = exact + np.random.default_rng(1).normal(0.0, 4e-5, len(time))
    return time, segment, voltage, exact, measured
