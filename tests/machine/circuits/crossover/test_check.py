"""The certificate of circuits that a crossover joins: what it lets through, and what it must not."""

import numpy as np
import pytest

from helpers.crossover_made import random_states
from polydraulic.machine.circuits.crossover.check import SURE, joined_deliver, joined_end
from polydraulic.machine.circuits.crossover.circuit import joined_4
from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice, JoinedPumps
from polydraulic.machine.circuits.crossover.passes import Joining, joined_begin, joined_pass, joined_path
from polydraulic.machine.circuits.series.check import PROVED, UNPROVED
from polydraulic.machine.pump import Circuit, delivered
from polydraulic.machine.valve import Orifices


def settled(machine, size, seed) -> list[tuple[Joining, JoinedPumps]]:
    """States of real valves whose passes settle."""
    crosses, inlets, bypasses, ports, gives, takes = random_states(machine, "real", 0.0, size, seed)
    found = []
    for i in range(size):
        k = [Orifices(a, b, 0.0) for a, b in zip(inlets[i], bypasses[i], strict=True)]
        v = joined_4(CrossoverOrifice(*crosses[i]), *k, *ports[i], gives, takes)
        r, x = joined_path(v), joined_begin(gives, takes)
        for _ in range(24):
            x = joined_pass(x, r, v.ports, gives, takes, False, False)
        if x.still:
            found.append((x, v))
    return found


@pytest.mark.parametrize("moved", ["crosses", "w", "arrives"])
def test_what_is_proved_is_no_further_off_than_it_may_be(machine, moved):
    """Flows changed by ten times that; where an orifice is shut, or takes all there is, the change may be taken back."""
    found, refused = settled(machine, 20, 11), 0
    assert len(found) > 15
    for x, v in found:
        r, flow = joined_path(v), min(v.gives.flow, v.takes.flow)
        true = joined_end(x, r, v)
        assert true.status == PROVED
        for by in (10.0 * SURE * flow, -10.0 * SURE * flow):
            off = x._replace(**{moved: getattr(x, moved) + by})
            if moved == "crosses":
                off = off._replace(arrives=off.arrives + by)
            given = joined_end(off, r, v)
            refused += given.status == UNPROVED
            assert given.status == UNPROVED or np.abs(np.subtract(given[:5], true[:5])).max() <= SURE * flow
    assert refused > len(found)  # more than half


def test_pumps_deliver_what_their_torque_limit_lets_them(machine):
    pump = random_states(machine, "real", 1.0, 1, 12).gives
    q = delivered(2.0e7, pump)
    assert q < pump.flow
    at = Circuit(q, 0.0, 0.0, 2.0e7, 0.0)
    assert joined_deliver(at, at, pump, pump)
    assert not joined_deliver(at, at._replace(q_pump=q + 2.0 * SURE * pump.flow), pump, pump)
    assert not joined_deliver(at._replace(p_pump=2.0e7 + 1.0), at, pump, pump)


def test_a_node_that_nothing_reaches_has_a_finite_pressure(machine):
    for _, v in settled(machine, 5, 13):
        shut = v._replace(k_2=Orifices(0.0, 0.0, 0.0), k_4=Orifices(0.0, 0.0, 0.0))
        r = joined_path(shut)
        y = joined_begin(v.gives, v.takes)
        for _ in range(24):
            y = joined_pass(y, r, v.ports, v.gives, v.takes, False, False)
        found = joined_end(y, r, shut)
        assert found.status == PROVED
        assert found.q_2 == found.q_4 == 0.0
        assert np.all(np.abs([found.p_giving, found.p_taking]) <= 1.1 * v.gives.relief)
