"""Torque that a motion needs: that of Newton and Euler written with vectors, on machines with arms in space and joints that slide."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.machine.frames import link_frames
from polydraulic.machine.newton_euler import axis_of, needed_wrenches
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.watch.blocks import block_shape
from polydraulic.watch.kernels.motion import needed_torques
from polydraulic.watch.residuals import Residuals, case_of


@pytest.mark.parametrize(("name", "payload"), [("cat215b", 400.0), ("loader_crane", 0.0)])
def test_needed_torques_are_those_of_vectors(name, payload):
    machine, n = load_machine(name), 3
    residuals = Residuals([], block_shape(0.02), ())
    residuals.instants = n
    rng, joints = np.random.default_rng(7), len(machine.functions)
    q, qd, qdd = rng.normal(size=(3, n, joints))
    plan = residuals.plan
    places = [tuple(plan.room(n) for _ in range(3)) for _ in range(joints)]
    out = residuals._needed(case_of(machine, payload), places)
    arrays, work = plan.arrays(), np.zeros(plan.size)
    for joint, moved in enumerate(places):
        for place, values in zip(moved, (q, qd, qdd), strict=True):
            work[place : place + n] = values[:, joint]
    needed_torques(arrays.ints, arrays.floats, work, arrays.ints[1] + 1)
    loaded = with_payload(machine, payload)
    frames = link_frames(loaded, q)
    wrenches = needed_wrenches(loaded, frames, qd, qdd, np.zeros((n, 3)))
    for joint, f in enumerate(loaded.functions):
        link, wrench = loaded.link(f.moves), wrenches[f.name]
        carried = wrench.moment if link.joint == "revolute" else wrench.force
        expected = (carried * axis_of(link, frames)).sum(axis=1)
        assert work[out + joint * n : out + (joint + 1) * n] == pytest.approx(expected, rel=1e-9, abs=1e-6)
