"""The machine in the form that general solvers are given: each pump pressure is a state behind a small volume.

C dP/dt = Q - Q_i - Q_e for the boom's pump, the other one, and between the valves of swing and stick; 18 states. The text of the machine in
continuous time is the package's, but for its flows, which follow from the pressures that are given.
"""

import numpy as np

from polydraulic import load_machine, load_scenario
from polydraulic._kernel import driver, kernel
from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.pilot import spool_target
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.simulation.layout.methods.text import methods_text
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.thesis.excavator import LINKS, pump_of

VOLUME = 1e-5 * 1.6387064e-5 / 6894.757293168361  # m3/Pa: 1e-5 in3/psi, each pump's line
FRAME = 5e-3
N_STIFF = 18
SOLVED = "return exact_step(valves, spool, seen.p_in)"
GIVEN = '''
from polydraulic.machine.pump import Circuit
from polydraulic.machine.valve import orifice_flow


class Given(NamedTuple):
    """Pump pressures from outside, and the valves."""

    swing: ValveTables_6
    boom: ValveTables_6
    stick: ValveTables_6
    p_return: float
    q_boom: float
    q_series: float
    p_boom: float
    p_series: float
    p_between: float


@kernel
def given_step(model: Given, spool: Functions, p_in: Functions) -> Flows:
    """Flows of all orifices at the given pressures, each with its check valve; what passes the swing's valve in place of the relief."""
    swing = orifices_6(spool.swing, model.swing)
    boom = orifices_6(spool.boom, model.boom)
    stick = orifices_6(spool.stick, model.stick)
    to_swing = orifice_flow(swing.inlet, model.p_series - p_in.swing)
    to_boom = orifice_flow(boom.inlet, model.p_boom - p_in.boom)
    to_stick = orifice_flow(stick.inlet, model.p_between - p_in.stick)
    past_boom = orifice_flow(boom.bypass, model.p_boom - model.p_return)
    passed = orifice_flow(swing.bypass, model.p_series - model.p_between)
    past_stick = orifice_flow(stick.bypass, model.p_between - model.p_return)
    return Flows(
        Functions(to_swing, to_boom, to_stick),
        Functions(swing.outlet, boom.outlet, stick.outlet),
        Circuit(model.q_boom, past_boom, 0.0, model.p_boom, 0.0),
        Circuit(model.q_series, past_stick, passed, model.p_series, 0.0),
        model.p_between,
        OK,
    )


'''
SCENARIO = load_scenario("task")
MACHINE = adapted(load_machine("cat215b"), SCENARIO)
READY = prepare_layout(MACHINE, 1.0)
STEP = READY.module


def given_text():
    """Text of the methods, with flows from pressures that are given; the machine's tables have six knots."""
    text = methods_text(MACHINE)
    assert text.count(SOLVED) == 1
    before, after = text.replace(SOLVED, SOLVED.replace("exact_step", "given_step")).split("class Rates(NamedTuple):")
    return f"{before}{GIVEN}class Rates(NamedTuple):{after}"


METHODS = loaded(given_text())
Given, rates = METHODS.Given, METHODS.rates
Functions, State, Held, from_vector = STEP.Functions, STEP.State, STEP.Held, STEP.from_vector
P_RETURN, FLOOR, BOOM_FLOW, SERIES_FLOW = (
    MACHINE.tank.return_pressure,
    MACHINE.tank.floor,
    pump_of(MACHINE, "boom").flow,
    pump_of(MACHINE, "series").flow,
)
PLANT, VALVES, FREE, PUSH = READY.plant, READY.valves, Held(False, False, False), STEP.Force(0.0, 0.0, 0.0)
V_SWING, V_BOOM, V_STICK = VALVES.valve_swing, VALVES.valve_boom, VALVES.valve_stick
TAU = Functions(*(MACHINE.function(link).pilot.time_constant for link in LINKS))
N_FRAME = round(SCENARIO.duration / FRAME)
TIME = np.arange(N_FRAME + 1) * FRAME
CORNERS = [np.asarray(SCENARIO.voltage[link].time) for link in LINKS]
VOLTS = [np.asarray(SCENARIO.voltage[link].voltage) for link in LINKS]
T0, T1, T2 = CORNERS
V0, V1, V2 = VOLTS
HELD_VOLTS = step_inputs(MACHINE, SCENARIO, TIME[:-1])
SIZE = (1e-3, 1e6, 1e6, 1.0, 1.0)  # units of the peers' states, so that one absolute tolerance suits all
UNITS = np.concatenate([np.repeat(SIZE, 3), np.full(3, SIZE[1])])
BAND = 1e4  # Pa; make-up valves open over it, since a jump in the rates would hold the peers up


@kernel
def scaled(x, size):
    return Functions(x.swing * size, x.boom * size, x.stick * size)


@kernel
def filled(p, rate):
    return rate * (min(max((p - FLOOR) / BAND, 0.0), 1.0) if rate < 0.0 else 1.0)


@kernel
def all_filled(p, rate):
    return Functions(filled(p.swing, rate.swing), filled(p.boom, rate.boom), filled(p.stick, rate.stick))


@kernel
def stiff_rates(voltage, y, f):
    """Derivatives of 15 states and three pressures, in the peers' units."""
    p_boom, p_series, p_between = SIZE[1] * y[15], SIZE[1] * y[16], SIZE[1] * y[17]
    model = Given(V_SWING, V_BOOM, V_STICK, P_RETURN, BOOM_FLOW, SERIES_FLOW, p_boom, p_series, p_between)
    v = from_vector(y)
    x = State(
        scaled(v.spool, SIZE[0]),
        scaled(v.p_a, SIZE[1]),
        scaled(v.p_b, SIZE[2]),
        scaled(v.angle, SIZE[3]),
        scaled(v.rate, SIZE[4]),
    )
    r = rates(model, PLANT, FREE, x, PUSH)
    swing, boom, stick = PLANT.swing.pilot, PLANT.boom.pilot, PLANT.stick.pilot
    f[0] = (spool_target(voltage.swing, swing) - x.spool.swing) / TAU.swing / SIZE[0]
    f[1] = (spool_target(voltage.boom, boom) - x.spool.boom) / TAU.boom / SIZE[0]
    f[2] = (spool_target(voltage.stick, stick) - x.spool.stick) / TAU.stick / SIZE[0]
    a, b = all_filled(x.p_a, r.p_a), all_filled(x.p_b, r.p_b)
    f[3], f[4], f[5] = a.swing / SIZE[1], a.boom / SIZE[1], a.stick / SIZE[1]
    f[6], f[7], f[8] = b.swing / SIZE[2], b.boom / SIZE[2], b.stick / SIZE[2]
    f[9], f[10], f[11] = x.rate.swing, x.rate.boom, x.rate.stick
    f[12], f[13], f[14] = r.acceleration.swing, r.acceleration.boom, r.acceleration.stick
    q, at_boom, at_series = r.flows.q_in, r.flows.circuit_boom, r.flows.circuit_series
    f[15] = (BOOM_FLOW - q.boom - at_boom.q_bypass) / (VOLUME * SIZE[1])
    f[16] = (SERIES_FLOW - q.swing - at_series.q_relief) / (VOLUME * SIZE[1])
    f[17] = (at_series.q_relief - q.stick - at_series.q_bypass) / (VOLUME * SIZE[1])


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
    stiff_rates(Functions(line(t, T0, V0), line(t, T1, V1), line(t, T2, V2)), y, f)


@driver
def held(v0, v1, v2, y, f):
    stiff_rates(Functions(v0, v1, v2), y, f)


def start():
    """Rest, with pump pressures that the bypasses hold."""
    y = np.concatenate([READY.start, np.full(3, 2.0 * P_RETURN)]) / UNITS
    f = np.empty(N_STIFF)
    for _ in range(100_000):
        held(0.0, 0.0, 0.0, y, f)
        y[15:] += 2e-7 * f[15:]
    return y
