"""How far the joints of a machine are moved, and how fast they go, roughly; outward and inward, as its arm stands."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.reach.tip import slew_sign, tip_at_joints
from polydraulic.parameters.layout.schema import LayoutMachine

_SLEW = np.pi / 3.0  # rad, to either side, of joints that turn all the way round
_STROKE, _ROUND = 5.0, 0.6  # s of a stroke at full lever, in machines of this kind; rad/s of joints that turn round


class JointTravels(NamedTuple):
    """Joints of a machine.

    Attributes
    ----------
    machine : LayoutMachine
    low, high : (n_function,) arrays, rad or m
        End stops; of joints that turn all the way round, how far they are turned here.
    turns : (n_function,) array of bool
        Whether a joint turns all the way round.
    full : (n_function,) array, rad/s or m/s
        What joints do at full lever, roughly.
    """

    machine: LayoutMachine
    low: np.ndarray
    high: np.ndarray
    turns: np.ndarray
    full: np.ndarray


def travels_of(machine: LayoutMachine) -> JointTravels:
    """JointTravels of a machine's joints."""
    stops = np.array([(f.stops.low, f.stops.high) for f in machine.functions])
    initial = np.array([f.initial.angle for f in machine.functions])
    revolute = np.array([machine.link(f.moves).joint == "revolute" for f in machine.functions])
    turns = revolute & (np.ptp(stops, axis=1) > 2.0 * np.pi)
    low = np.where(turns, initial - _SLEW, stops[:, 0])
    high = np.where(turns, initial + _SLEW, stops[:, 1])
    return JointTravels(machine, low, high, turns, np.where(turns, _ROUND, (high - low) / _STROKE))


def outward(machine: LayoutMachine, tips: np.ndarray) -> np.ndarray:
    """From the first joint to tips (n, 3), level, (n, 2) in m."""
    at = machine.link(machine.functions[0].moves).at
    return np.asarray(tips[:, :2] - (at.get("x", 0.0), at.get("y", 0.0)))


def inward(machine: LayoutMachine, positions: np.ndarray) -> np.ndarray:
    """Level direction from the tip to the machine in the plane of its arm, (n, 3); joint positions as for `tip_at_joints`."""
    plane = _plane(machine, positions)
    away = np.sign(out_of(machine, positions))[:, None]
    return np.column_stack([-away * plane, np.zeros(len(positions))])


def out_of(machine: LayoutMachine, positions: np.ndarray) -> np.ndarray:
    """How far the tip is from the first joint in the plane of the arm, (n,) in m, negative behind it; joint positions as for `tip_at_joints`."""
    tips = tip_at_joints(machine, positions)
    return np.asarray((outward(machine, tips) * _plane(machine, positions)).sum(axis=1))


def _plane(machine: LayoutMachine, positions: np.ndarray) -> np.ndarray:
    """Level direction in which the arm points, (n, 2)."""
    heading = slew_sign(machine) * positions[:, 0]
    return np.column_stack([np.cos(heading), np.sin(heading)])
