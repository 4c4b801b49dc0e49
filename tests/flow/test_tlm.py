"""Transmission lines: known answers of waves, the oil in the lines, and the way to exact and to the stiff equations."""

import numpy as np
import pytest

from helpers.flow_steps import Links, flow_step, held_still, layout_step
from helpers.valves import circuit_pump
from polydraulic import build_flow, compare, load_machine, load_scenario, simulate
from polydraulic.errors import InputError
from polydraulic.machine.pump import delivered
from polydraulic.thesis.excavator import with_pumps
from polydraulic.units import to_si

PSI = to_si(1.0, "psi")
DT = 0.005
CENTRE = Links(0.0, 0.0, 0.0)
REST = Links(0.0, 0.0, 0.0)


@pytest.fixture(scope="module", params=[False, True], ids=["constant", "limited"])
def pumped(request, machine):
    return with_pumps(machine, torque_limit_enabled=request.param)


def dead_ended(machine):
    """Without any orifice: the pump works into a closed line."""
    nothing = (0.0,) * 6
    return machine._replace(
        functions=tuple(f._replace(valve=f.valve._replace(inlet=nothing, bypass=nothing)) for f in machine.functions)
    )


def test_a_closed_line_fills_in_steps(machine):
    """Each wave of the pump's flow doubles at the closed valve: 2 Z Q every second delay, mean rate Q / C."""
    closed = dead_ended(machine)
    model = build_flow("tlm", closed, volume=1e-2, alpha=0.0, substeps=1)
    Q, C = circuit_pump(machine, "boom").flow, model.parts["tlm_lines"].compliance
    Z = DT / C
    memory = np.array([1e6, 1e6, 1e6, 1e6, 1e6, 1e6, 1.0])
    seen = [flow_step(closed, model, memory, CENTRE, REST, REST, DT).boom.p_pump - 1e6 for _ in range(8)]
    assert seen == pytest.approx([n * Z * Q for n in (0, 2, 2, 4, 4, 6, 6, 8)], rel=1e-12, abs=1e-6)
    assert 0.5 * C * (memory[0] + memory[1] - 2e6) == pytest.approx(8 * DT * Q, rel=1e-12)


@pytest.mark.parametrize("alpha", [0.1, 0.5])
def test_the_low_pass_loses_no_oil(machine, alpha):
    closed = dead_ended(machine)
    model = build_flow("tlm", closed, volume=1e-2, alpha=alpha, substeps=3)
    memory = np.array([1e6, 1e6, 1e6, 1e6, 1e6, 1e6, 1.0])
    stored = [flow_step(closed, model, memory, CENTRE, REST, REST, DT).boom.q_stored for _ in range(8)]
    assert stored == pytest.approx([circuit_pump(machine, "boom").flow] * 8, rel=1e-9)
    assert 0.5 * model.parts["tlm_lines"].compliance * (memory[0] + memory[1] - 2e6) == pytest.approx(
        sum(stored) * DT, rel=1e-9
    )


def test_the_relief_valve_ends_the_rise_of_a_closed_line(pumped):
    closed, boom = dead_ended(pumped), circuit_pump(pumped, "boom")
    model = build_flow("tlm", closed)
    memory = np.zeros(7)
    for _ in range(400):
        flows = flow_step(closed, model, memory, CENTRE, REST, REST, DT)
        assert flows.boom.p_pump <= boom.relief
    assert flows.boom.p_pump == pytest.approx(boom.relief, rel=1e-9)
    assert flows.boom.q_relief == pytest.approx(delivered(boom.relief, boom), rel=1e-9)


def test_waves_below_the_floor_are_made_up(pumped):
    spool, p_in = Links(0.0075, -0.0065, 0.0071), Links(0.0, 0.0, 0.0)
    model, low = build_flow("tlm", pumped, substeps=1), pumped.tank.floor
    memory = np.array([-3e7] * 6 + [1.0])
    for _ in range(20):
        flows = flow_step(pumped, model, memory, spool, p_in, p_in, DT)
        assert min(flows.boom.p_pump, flows.series.p_pump, flows.p_between) >= low
        assert min(*flows.q_in, flows.boom.q_bypass, flows.series.q_bypass) >= 0.0


@pytest.mark.parametrize(("volume", "alpha"), [(1e-4, 0.3), (1e-3, 0.1), (1e-2, 0.0)])
def test_held_still_it_becomes_exact(pumped, volume, alpha):
    model = build_flow("tlm", pumped, volume=volume, volume_between=0.2 * volume, alpha=alpha)
    spool, p_in = Links(0.0075, -0.0065, 0.0071), Links(500 * PSI, 1500 * PSI, 900 * PSI)
    memory = np.array([1e5, 3e7, 1e5, 1e7, 2e6, 3e6, 1.0])
    flows = held_still(pumped, model, memory, spool, p_in, 2000)
    still = flow_step(pumped, build_flow("exact", pumped), np.zeros(1), spool, p_in, p_in, DT)
    assert flows.q_in == pytest.approx(still.q_in, rel=1e-6)
    assert flows.series == pytest.approx(still.series, rel=1e-6, abs=1e-12)
    assert flows.p_between == pytest.approx(still.p_between, rel=1e-6)


def test_it_begins_at_rest(pumped):
    spool, p_in = Links(0.0075, -0.0065, 0.0071), Links(500 * PSI, 1500 * PSI, 900 * PSI)
    flows = flow_step(pumped, build_flow("tlm", pumped), np.zeros(7), spool, p_in, p_in, DT)
    still = flow_step(pumped, build_flow("exact", pumped), np.zeros(1), spool, p_in, p_in, DT)
    assert flows.q_in == pytest.approx(still.q_in, rel=1e-7)
    assert abs(flows.series.q_stored) < 1e-7 * flows.series.q_pump


@pytest.mark.slow_to_compile
def test_circuits_of_any_length_become_exact():
    machine = load_machine("excavator_22t")
    assert max(len(c.functions) for c in machine.circuits) == 3
    step, still = (layout_step(machine, build_flow(name, machine), DT) for name in ("tlm", "exact"))
    spool = [0.7 * f.valve.knots[-1] for f in machine.functions]
    p_in = [(3.0 + place) * 1e6 for place in range(len(spool))]
    first, wanted = step(spool, p_in, p_in), still(spool, p_in, p_in)
    assert first.q_in == pytest.approx(wanted.q_in, rel=1e-6)  # it begins at rest
    other = [0.5 * f.valve.knots[-1] for f in machine.functions]
    away = step(other, p_in, p_in)
    assert max(abs(c.q_stored) for c in away if hasattr(c, "q_stored")) > 1e-4
    for _ in range(500):
        found = step(spool, p_in, p_in)
    for ours, true in zip(found[:-1], wanted[:-1], strict=True):
        assert ours == pytest.approx(true, rel=1e-6, abs=1e-12)


def orders(scales, errors):
    return np.polyfit(np.log(scales), np.log(errors), 1)[0]


@pytest.mark.slow
def test_the_flows_approach_exact_as_volume_and_delay_shrink(pumped):
    """First order, with the impedance held: half the volume, half the delay."""
    scenario, substeps = load_scenario("task"), [2, 8, 32]
    exact = simulate(pumped, "exact", scenario, t_end=6.0)
    runs = [
        simulate(
            pumped,
            build_flow("tlm", pumped, volume=2e-3 / n, volume_between=4e-4 / n, substeps=n),
            scenario,
            t_end=6.0,
        )
        for n in substeps
    ]
    for column in ("swing.q_in", "boom.q_in", "stick.q_in", "series.p_pump", "series.p_between"):
        errors = [compare(exact, run)[column].rms for run in runs]
        assert 0.85 < -orders(substeps, errors) < 1.3, column


@pytest.mark.slow
def test_the_delay_alone_is_of_second_order(pumped):
    """Without low pass a line is its volume and an inertia in proportion to the delay squared; seen in the mean flow."""
    scenario, substeps = load_scenario("sine"), [2, 4, 8]
    runs = {
        n: simulate(pumped, build_flow("tlm", pumped, alpha=0.0, substeps=n), scenario, t_end=2.4)
        for n in (*substeps, 64)
    }
    errors = [compare(runs[64], runs[n])["swing.q_in"].rms for n in substeps]
    assert 1.7 < -orders(substeps, errors) < 2.3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"alpha": 1.0}, r"alpha = 1.0: must lie in \[0, 1\)"),
        ({"substeps": 0}, "substeps = 0: must be a whole number, at least 1"),
        ({"substeps": 1.5}, "substeps = 1.5"),
    ],
)
def test_bad_settings_are_named(machine, options, message):
    with pytest.raises(InputError, match=message):
        build_flow("tlm", machine, **options)
    with pytest.raises(InputError, match=message):
        build_flow("tlm", "wheel_loader", **options)
