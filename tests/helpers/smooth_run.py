"""A run in which nothing but smooth motion happens: for methods at equal conditions."""

import numpy as np

from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.thesis.excavator import LINKS

# All valves stay on one segment of their tables after 0.8 s, and no line meets a bound: nothing but smooth motion.
VOLTS = (0.41, 0.3, 0.62)
SMOOTH = Scenario("smooth", 1.2, {link: Constant(v) for link, v in zip(LINKS, VOLTS, strict=True)})
START, LENGTH = 0.8, 0.4  # s


def angles(table):
    return np.column_stack([table[f"{link}.angle"] for link in LINKS])


def joint_errors(found, tight):
    """Largest error of each joint in degrees."""
    return np.degrees(np.abs(angles(found) - angles(tight)).max(axis=0))
