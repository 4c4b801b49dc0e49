"""Random states of circuits with a crossover, solved by the package and by the judge."""

from typing import NamedTuple

import numpy as np

from helpers.crossover_judge import judge_all
from helpers.series_made import STATES, pump_of
from polydraulic._kernel import driver, kernel
from polydraulic.machine.circuits.crossover.check import joined_end
from polydraulic.machine.circuits.crossover.circuit import (
    crossed_4,
    crossover_3,
    crossover_4,
    joined_4,
    joined_bracketed,
)
from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice
from polydraulic.machine.circuits.crossover.passes import JOINED_PASSES, joined_begin, joined_pass, joined_path
from polydraulic.machine.pump import Pump
from polydraulic.machine.valve import Orifices

# columns of what is found; the judge's are the same
FLOWS = ("q_1", "q_2", "q_3", "q_4", "q_cross")
PUMPS = ("q_pump", "q_tank", "q_relief", "p_pump")
N_JUDGED = len(FLOWS) + 2 * len(PUMPS) + 1
N_FOUND = N_JUDGED + 2  # status, pressures behind both first valves
STATUS, BEHIND_GIVING, BEHIND_TAKING = 13, 14, 15
_PRESSURES = [8, BEHIND_GIVING, 12, BEHIND_TAKING]


class States(NamedTuple):
    """Conductance and opening pressure of crossovers, inlets, bypasses and ports of four valves, and the pumps."""

    crosses: np.ndarray
    inlets: np.ndarray
    bypasses: np.ndarray
    ports: np.ndarray
    gives: Pump
    takes: Pump


@kernel
def put(s, out):
    """Write what four valves give."""
    g, t = s.giving, s.taking
    out[0], out[1], out[2], out[3], out[4] = g.q_in_1, g.q_in_2, t.q_in_1, t.q_in_2, s.q_cross
    out[5], out[6], out[7], out[8] = g.circuit.q_pump, g.circuit.q_bypass, g.circuit.q_relief, g.circuit.p_pump
    out[9], out[10], out[11], out[12] = t.circuit.q_pump, t.circuit.q_bypass, t.circuit.q_relief, t.circuit.p_pump
    out[13], out[14], out[15] = g.status, g.p_between_1, t.p_between_1


@driver
def solve_all(crosses, inlets, bypasses, ports, gives, takes, out):
    """Rows of four valves."""
    for i in range(crosses.shape[0]):
        orifice = CrossoverOrifice(crosses[i, 0], crosses[i, 1])
        k_1, k_2 = Orifices(inlets[i, 0], bypasses[i, 0], 0.0), Orifices(inlets[i, 1], bypasses[i, 1], 0.0)
        k_3, k_4 = Orifices(inlets[i, 2], bypasses[i, 2], 0.0), Orifices(inlets[i, 3], bypasses[i, 3], 0.0)
        p_1, p_2, p_3, p_4 = ports[i, 0], ports[i, 1], ports[i, 2], ports[i, 3]
        put(crossover_4(orifice, k_1, k_2, k_3, k_4, p_1, p_2, p_3, p_4, gives, takes), out[i])


@driver
def solve_three(crosses, inlets, bypasses, ports, gives, takes, out):
    """Rows of three valves: the second of the four is left out."""
    for i in range(crosses.shape[0]):
        orifice = CrossoverOrifice(crosses[i, 0], crosses[i, 1])
        k_1 = Orifices(inlets[i, 0], bypasses[i, 0], 0.0)
        k_3, k_4 = Orifices(inlets[i, 2], bypasses[i, 2], 0.0), Orifices(inlets[i, 3], bypasses[i, 3], 0.0)
        s = crossover_3(orifice, k_1, k_3, k_4, ports[i, 0], ports[i, 2], ports[i, 3], gives, takes)
        g, t = s.giving, s.taking
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4] = g.q_in_1, 0.0, t.q_in_1, t.q_in_2, s.q_cross
        out[i, 5], out[i, 6], out[i, 7], out[i, 8] = g.circuit[0], g.circuit[1], g.circuit[2], g.circuit[3]
        out[i, 9], out[i, 10], out[i, 11], out[i, 12] = t.circuit[0], t.circuit[1], t.circuit[2], t.circuit[3]
        out[i, 13], out[i, 14], out[i, 15] = g.status, gives.p_return, t.p_between_1


def random_states(machine, kind, exponent, size, seed):
    """States of a kind of `series_made`; crossovers over three decades, some shut or just opening, some with an opening pressure; one pump is smaller."""
    rng = np.random.default_rng(seed)
    inlets, bypasses, ports = STATES[kind](machine, 4, size, rng)
    crosses = np.zeros((size, 2))
    crosses[:, 0] = np.where(rng.random(size) < 0.1, 0.0, 10.0 ** rng.uniform(-8.0, -5.0, size))
    opening = np.where(rng.random(size) < 0.3, 10.0 ** rng.uniform(-12.0, -3.0, size), 1.0)
    crosses[:, 0] *= opening
    crosses[:, 1] = np.where(rng.random(size) < 0.5, 0.0, rng.uniform(0.0, 2e6, size))
    gives = pump_of(machine, exponent)
    takes = gives._replace(flow=0.8 * gives.flow)
    return States(crosses, inlets, bypasses, ports, *((gives, takes) if seed % 2 else (takes, gives)))


def solved(states, loop=solve_all):
    """Rows of what is found."""
    out = np.empty((len(states.crosses), N_FOUND))
    loop(*states, out)
    return out


def judged(states, found):
    """Flows and pressures by the judge, and its doubt as the last column; it begins near the pressures that were found."""
    out, near = np.empty((len(found), N_JUDGED)), np.ascontiguousarray(found[:, _PRESSURES])
    judge_all(*states, near, out)
    return out


def off(found, true, states):
    """Largest error of the flows of each state, as a share of the smaller pump's flow."""
    flows = [0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 11]
    return np.abs(found[:, flows] - true[:, flows]).max(axis=1) / min(states.gives.flow, states.takes.flow)


@driver
def bracket_all(crosses, inlets, bypasses, ports, gives, takes, out):
    """Rows of four valves by brackets alone."""
    for i in range(crosses.shape[0]):
        orifice = CrossoverOrifice(crosses[i, 0], crosses[i, 1])
        k_1, k_2 = Orifices(inlets[i, 0], bypasses[i, 0], 0.0), Orifices(inlets[i, 1], bypasses[i, 1], 0.0)
        k_3, k_4 = Orifices(inlets[i, 2], bypasses[i, 2], 0.0), Orifices(inlets[i, 3], bypasses[i, 3], 0.0)
        v = joined_4(orifice, k_1, k_2, k_3, k_4, ports[i, 0], ports[i, 1], ports[i, 2], ports[i, 3], gives, takes)
        put(crossed_4(joined_bracketed(v)), out[i])


@driver
def attempt_all(crosses, inlets, bypasses, ports, gives, takes, torque, out):
    """Rows of four valves by passes and certificate alone; in place of the pressure behind the giving pump's first valve stands whether all has settled. `torque`: passes that know torque limits."""
    for i in range(crosses.shape[0]):
        orifice = CrossoverOrifice(crosses[i, 0], crosses[i, 1])
        k_1, k_2 = Orifices(inlets[i, 0], bypasses[i, 0], 0.0), Orifices(inlets[i, 1], bypasses[i, 1], 0.0)
        k_3, k_4 = Orifices(inlets[i, 2], bypasses[i, 2], 0.0), Orifices(inlets[i, 3], bypasses[i, 3], 0.0)
        v = joined_4(orifice, k_1, k_2, k_3, k_4, ports[i, 0], ports[i, 1], ports[i, 2], ports[i, 3], gives, takes)
        r, x = joined_path(v), joined_begin(gives, takes)
        for _ in range(JOINED_PASSES):
            if torque:
                x = joined_pass(x, r, v.ports, gives, takes, True, True)
            else:
                x = joined_pass(x, r, v.ports, gives, takes, False, False)
        found = joined_end(x, r, v)
        put(crossed_4(found), out[i])
        out[i, BEHIND_GIVING] = 1.0 if x.still else 0.0


def attempted(states, torque=False):
    """Rows of what passes find alone, without brackets."""
    out = np.empty((len(states.crosses), N_FOUND))
    attempt_all(*states, torque, out)
    return out
