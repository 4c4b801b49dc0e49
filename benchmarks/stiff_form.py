"""The machine in the form that general solvers are given: each pump pressure is a state behind a small volume.

C dP/dt = Q - Q_i - Q_e for the boom's pump, the other one, and between the valves of swing and stick; 18 states with the package's kernels.
"""

from typing import NamedTuple

import numpy as np
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import prepare
from polydraulic.simulation.solvers.right_hand_side import rates

from polydraulic import load_machine, load_scenario
from polydraulic._kernel import driver, kernel
from polydraulic.flow.dispatch import FLOW_STEPS
from polydraulic.flow.exact import Valves, prepare_valves
from polydraulic.flow.interface import OK, Flows
from polydraulic.flow.record import from_vector, to_vector
from polydraulic.machine.pilot import spool_target
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links, State, initial_state
from polydraulic.machine.valve import orifice_flow, orifices
from polydraulic.simulation.runs import step_voltages
from polydraulic.thesis.excavator import LINKS, pump_of

VOLUME = 1e-5 * 1.6387064e-5 / 6894.757293168361  # m3/Pa: 1e-5 in3/psi, each pump's line
FRAME = 5e-3
N_STIFF = 18


class Given(NamedTuple):
    """A flow model whose pump pressures are given from outside."""

    valves: Valves
    p_boom: float
    p_series: float
    p_between: float


@kernel
def given_step(model, memory, spool, p_in, p_out, dt):
    """Flows of all orifices at the given pressures, each with its check valve."""
    swing, boom = orifices(spool.swing, model.valves.swing), orifices(spool.boom, model.valves.boom)
    stick = orifices(spool.stick, model.valves.stick)
    to_boom, past_boom = (
        orifice_flow(boom.inlet, model.p_boom - p_in.boom),
        orifice_flow(boom.bypass, model.p_boom - P_RETURN),
    )
    to_swing = orifice_flow(swing.inlet, model.p_series - p_in.swing)
    passed = orifice_flow(swing.bypass, model.p_series - model.p_between)
    to_stick = orifice_flow(stick.inlet, model.p_between - p_in.stick)
    past_stick = orifice_flow(stick.bypass, model.p_between - P_RETURN)
    return Flows(
        Links(to_swing, to_boom, to_stick),
        Links(swing.outlet, boom.outlet, stick.outlet),
        Circuit(BOOM_FLOW, past_boom, 0.0, model.p_boom, 0.0),
        Circuit(
            SERIES_FLOW, past_stick, passed, model.p_series, 0.0
        ),  # what passes the swing valve in place of the relief
        model.p_between,
        OK,
    )


FLOW_STEPS[Given] = given_step
SCENARIO = load_scenario("task")
MACHINE = SCENARIO.adapt(load_machine("cat215b"))
P_RETURN, FLOOR, BOOM_FLOW, SERIES_FLOW = (
    MACHINE.tank.return_pressure,
    MACHINE.tank.floor,
    pump_of(MACHINE, "boom").flow,
    pump_of(MACHINE, "series").flow,
)
PLANT, VALVES, FREE = prepare(MACHINE, 1.0), prepare_valves(MACHINE), Held(False, False, False)
TAU = Links(*(MACHINE.function(link).pilot.time_constant for link in LINKS))
N_FRAME = round(SCENARIO.duration / FRAME)
TIME = np.arange(N_FRAME + 1) * FRAME
CORNERS = [np.asarray(SCENARIO.voltage[link].time) for link in LINKS]
VOLTS = [np.asarray(SCENARIO.voltage[link].voltage) for link in LINKS]
T0, T1, T2 = CORNERS
V0, V1, V2 = VOLTS
HELD_VOLTS = step_voltages(MACHINE, SCENARIO, TIME[:-1])
SIZE = (1e-3, 1e6, 1e6, 1.0, 1.0)  # units of the peers' states, so that one absolute tolerance suits all
UNITS = np.concatenate([np.repeat(SIZE, 3), np.full(3, SIZE[1])])
BAND = 1e4  # Pa; make-up valves open over it, since a jump in the rates would hold the peers up


@kernel
def scaled(x, size):
    return Links(x.swing * size, x.boom * size, x.stick * size)


@kernel
def filled(p, rate):
    return rate * (min(max((p - FLOOR) / BAND, 0.0), 1.0) if rate < 0.0 else 1.0)


@kernel
def all_filled(p, rate):
    return Links(filled(p.swing, rate.swing), filled(p.boom, rate.boom), filled(p.stick, rate.stick))


@kernel
def stiff_rates(voltage, y, f):
    """Derivatives of 15 states and three pressures, in the peers' units."""
    model = Given(VALVES, SIZE[1] * y[15], SIZE[1] * y[16], SIZE[1] * y[17])
    v = from_vector(y)
    x = State(
        scaled(v.spool, SIZE[0]),
        scaled(v.p_a, SIZE[1]),
        scaled(v.p_b, SIZE[2]),
        scaled(v.angle, SIZE[3]),
        scaled(v.rate, SIZE[4]),
    )
    r = rates(model, y, PLANT, FREE, x)
    swing, boom, stick = PLANT.swing.pilot, PLANT.boom.pilot, PLANT.stick.pilot
    f[0] = (spool_target(voltage.swing, swing) - x.spool.swing) / TAU.swing / SIZE[0]
    f[1] = (spool_target(voltage.boom, boom) - x.spool.boom) / TAU.boom / SIZE[0]
    f[2] = (spool_target(voltage.stick, stick) - x.spool.stick) / TAU.stick / SIZE[0]
    a, b = all_filled(x.p_a, r.p_a), all_filled(x.p_b, r.p_b)
    f[3], f[4], f[5] = a.swing / SIZE[1], a.boom / SIZE[1], a.stick / SIZE[1]
    f[6], f[7], f[8] = b.swing / SIZE[2], b.boom / SIZE[2], b.stick / SIZE[2]
    f[9], f[10], f[11] = x.rate.swing, x.rate.boom, x.rate.stick
    f[12], f[13], f[14] = r.acceleration.swing, r.acceleration.boom, r.acceleration.stick
    q = r.flows
    f[15] = (BOOM_FLOW - q.q_in.boom - q.boom.q_bypass) / (VOLUME * SIZE[1])
    f[16] = (SERIES_FLOW - q.q_in.swing - q.series.q_relief) / (VOLUME * SIZE[1])
    f[17] = (q.series.q_relief - q.q_in.stick - q.series.q_bypass) / (VOLUME * SIZE[1])


@kernel
def line(t, times, volts):
    """Straight lines between points."""
    k = 0
    for i in range(1, times.shape[0] - 1):
        k = i if t >= times[i] else k
    share = (t - times[k]) / (times[k + 1] - times[k])
    return volts[k] + min(max(share, 0.0), 1.0) * (volts[k + 1] - volts[k])


@driver
def whole(t, y, f):
    stiff_rates(Links(line(t, T0, V0), line(t, T1, V1), line(t, T2, V2)), y, f)


@driver
def held(v0, v1, v2, y, f):
    stiff_rates(Links(v0, v1, v2), y, f)


def start():
    """Rest, with pump pressures that the bypasses hold."""
    y = np.concatenate([to_vector(initial_state(MACHINE)), np.full(3, 2.0 * P_RETURN)]) / UNITS
    f = np.empty(N_STIFF)
    for _ in range(100_000):
        held(0.0, 0.0, 0.0, y, f)
        y[15:] += 2e-7 * f[15:]
    return y
