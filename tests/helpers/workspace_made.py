"""A workspace by hand, so that tasks can be judged without a machine that moves."""

import numpy as np

from polydraulic import load_machine
from polydraulic.gym.motion import motion_from
from polydraulic.gym.workspace import Lines, Workspace
from polydraulic.machine.reach.travels import travels_of
from polydraulic.simulation.layout.prepare import start_vector


def workspace_made(name="cat215b"):
    """Two starts at one place, tips at a few, and a line of 1 m inward at 0.2 m/s."""
    machine = load_machine(name)
    n = len(machine.names)
    first = np.tile([6.0, 0.0, 1.0], (2, 1))
    return Workspace(
        machine,
        travels_of(machine),
        lever=np.full(n, 0.8),
        spool=np.full(n, 0.01),
        relief=np.full(n, 3e7),
        slews=1.0,
        tips=np.array([[6.0, 0.0, 1.0], [5.0, 1.0, 2.0], [4.0, 0.0, -1.0], [5.0, -1.0, 0.0]]),
        starts=np.tile(start_vector(machine), (2, 1)),
        start_tips=first,
        lines=Lines(first, first - [1.0, 0.0, 0.0], np.full(2, 0.2)),
    )


def motion_at(*tips, n_function=3, heading=0.0):
    """Machines that stand, with their tips at these places."""
    values = np.zeros((5 * n_function + 3, len(tips)))
    values[3 * n_function] = heading
    values[-3:] = np.transpose(tips)
    return motion_from(values)
