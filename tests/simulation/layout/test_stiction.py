"""Dry friction that holds: standing exactly still, letting go at the right torque, and stick-slip as an event-driven solver has it."""

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.small_crane import with_effects
from polydraulic import simulate, simulate_batch
from polydraulic.parameters.loads import Loads
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.schema import Friction
from polydraulic.parameters.signals import Constant, Piecewise
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.text import _written as layout_written
from polydraulic.simulation.layout.text import layout_of, layout_text

COMPILED = not numba.config.DISABLE_JIT


@pytest.fixture(scope="module")
def sticky(crane):
    return with_effects(crane, sticks=True)


def changed(machine, name, **parts):
    return machine._replace(functions=tuple(f._replace(**parts) if f.name == name else f for f in machine.functions))


def without_oil(machine, name):
    """The machine with an actuator so small that its oil does nothing to the joint."""
    f = machine.function(name)
    small = f.drive._replace(displacement=1e-20) if name == "slew" else f.drive._replace(bore=1e-9, rod=1e-10)
    return changed(machine, name, drive=small)


def test_a_boom_that_friction_alone_holds_does_not_move_by_a_bit(sticky):
    held = without_oil(without_oil(without_oil(sticky, "slew"), "lift"), "extend")
    dry = Friction(coulomb=8e3, static=9e3, viscous=100.0, smoothing=0.02, stribeck=0.05)
    held = changed(held, "lift", friction=dry)
    run = simulate(held, "exact", Scenario("hang", 600.0 if COMPILED else 5.0, {}), every=20)
    assert len(run["time"]) >= 51
    for column in ("slew.angle", "lift.angle", "extend.position"):
        assert set(run[column]) == {run[column][0]}, column
    for column in ("slew.rate", "lift.rate", "extend.speed"):
        assert set(run[column]) == {0.0}, column
    weak = changed(held, "lift", friction=dry._replace(coulomb=4e3, static=5e3))
    assert simulate(weak, "exact", Scenario("falls", 1.0, {}))["lift.angle"][-1] < run["lift.angle"][0] - 0.05


@pytest.mark.slow_to_compile
def test_a_joint_lets_go_at_the_static_torque_and_stops_again_below_it(sticky):
    """A force at the tip grows, falls, and turns: the slew moves only while its moment is above what friction takes."""
    dry = Friction(coulomb=1500.0, static=2400.0, viscous=800.0, smoothing=0.02, stribeck=0.05)
    machine = changed(without_oil(sticky, "slew"), "slew", friction=dry)
    force = Piecewise(np.array([0.0, 4.0, 6.0, 8.0]), np.array([0.0, 1600.0, 0.0, 0.0]))
    run = simulate(
        machine, "exact", Scenario("pull", 8.0, {}, loads=Loads({"y": force}), locked=("lift", "extend")), dt=1e-3
    )
    rate, angle, t = run["slew.rate"], run["slew.angle"], run["time"]
    moves = rate != 0.0
    first = np.flatnonzero(moves)[0]
    reach = np.hypot(run["effector.x"][0], run["effector.y"][0])
    begin = run["slew.angle"][0]
    lever = reach * np.cos(begin)  # of a force along y
    assert force(t[first - 1]) * lever == pytest.approx(2400.0, rel=2e-3)
    last = np.flatnonzero(moves)[-1]
    assert t[last] < 6.5
    assert np.all(moves[first:last])  # one slide
    assert set(angle[last + 1 :]) == {angle[last + 1]}
    assert np.all(rate >= 0.0)  # never through zero


@pytest.mark.slow_to_compile
@pytest.mark.parametrize(("pull", "turns"), [(-200.0, False), (-1500.0, True)])
def test_a_joint_whose_torque_turns_comes_to_rest_before_it_turns(sticky, pull, turns):
    dry = Friction(coulomb=1500.0, static=1500.0, viscous=0.0, smoothing=0.02, stribeck=0.05)
    machine = changed(without_oil(sticky, "slew"), "slew", friction=dry)
    force = Piecewise(np.array([0.0, 0.3, 0.31, 2.0]), np.array([1500.0, 1500.0, pull, pull]))
    scenario = Scenario("turn", 1.2, {}, loads=Loads({"y": force}), locked=("lift", "extend"))
    run = simulate(machine, "exact", scenario)
    rate = run["slew.rate"]
    assert rate.max() > 0.1
    first = np.flatnonzero(rate > 0.0)[-1] + 1  # at rest, or turned by no more than what the last step leaves
    assert (rate[first:] < 0.0).any() == turns
    if turns:
        assert abs(rate[first]) < np.abs(np.diff(rate[first + 1 : first + 5])).min() * 1.001
    else:
        assert set(run["slew.angle"][first:]) == {run["slew.angle"][first]}


def test_coupled_joints_meet_coulombs_law(sticky):
    """Of random momenta: a joint that moves is opposed by its whole friction, one that stands by no more than that."""
    ready = prepare_layout(sticky, 5e-3)
    module, plant, names = ready.module, ready.plant, sticky.names
    plain = {key: getattr(getattr(module, key), "py_func", getattr(module, key)) for key in ("position", "rubbed")}
    rng, stood, moved = np.random.default_rng(5), 0, 0
    for _ in range(300):
        q = [rng.uniform(f.stops.low, f.stops.high) for f in sticky.functions]
        w = np.where(rng.random(3) < 0.4, 0.0, rng.normal(0.0, 0.02, 3))
        mass = plain["position"](module.Functions(*q), module.Functions(*w), plant).motion.mass
        torque = rng.normal(0.0, 2.0, 3) * [f.friction.static for f in sticky.functions]
        momentum = module.momentum_after(mass, module.Functions(*w), module.Functions(*torque), plant.dt)
        rubbed = plain["rubbed"](mass, module.Held(False, False, False), module.Functions(*w), momentum, plant)
        assert not rubbed.unsettled
        after = rubbed.rate
        taken = np.array(momentum) - np.array(module.times(mass, after))
        for i, name in enumerate(names):
            f = sticky.function(name).friction
            most = plant.dt * (f.coulomb + (f.static - f.coulomb) * np.exp(-((w[i] / f.stribeck) ** 2)))
            if after[i] == 0.0:
                assert abs(taken[i]) <= most * (1 + 1e-9)
                stood += 1
            else:
                assert taken[i] == pytest.approx(np.sign(after[i]) * most, rel=1e-6)
                moved += 1
    assert min(stood, moved) > 150


@pytest.mark.slow_to_compile
def test_friction_that_does_not_settle_counts_as_not_converged_in_runs_and_lanes_alike(sticky, monkeypatch):
    """With a single pass, a joint that turns round or lets go within a step is not settled in it."""
    text = layout_text(sticky)
    hasty = text.replace("STICK_PASSES = 8", "STICK_PASSES = 1")
    assert hasty != text
    scenario = random_operator(4, 2.0, functions=sticky.names)
    patient = simulate(sticky, "exact", scenario)
    assert patient.info["steps_not_converged"] == 0
    monkeypatch.setitem(layout_written, (layout_of(sticky), "exact", False), hasty)
    alone = simulate(sticky, "exact", scenario)
    assert alone.info["steps_not_converged"] > 10
    together = simulate_batch(sticky, "exact", [scenario, random_operator(5, 2.0, functions=sticky.names)])
    assert together.not_converged[0] == alone.info["steps_not_converged"]


def test_stick_slip_of_a_slow_slew_is_that_of_an_event_driven_solver(sticky):
    """A slow pump winds up the oil until the slew breaks away; SciPy integrates slides and holds between their events."""
    dry = Friction(coulomb=1500.0, static=2600.0, viscous=150.0, smoothing=0.02, stribeck=0.02)
    f = sticky.function("slew")
    machine = changed(
        sticky,
        "slew",
        friction=dry,
        pilot=f.pilot._replace(time_constant=1e-3, dead_time=0.0),
        line=f.line._replace(compliance_a=7e-12, compliance_b=7e-12, leakage=0.0),
    )
    flow = 4e-5
    circuits = tuple(c._replace(pump=c.pump._replace(flow=flow, torque_limit_enabled=False)) for c in machine.circuits)
    machine = machine._replace(circuits=circuits)
    end, errors = 3.6, []
    for dt in (1e-3, 2.5e-4) if COMPILED else (1e-3,):
        run = simulate(
            machine, "exact", Scenario("creep", end, {"slew": Constant(1.0)}, locked=("lift", "extend")), dt=dt
        )
        k = round(0.05 / dt)
        start = [run[f"slew.{q}"][k] for q in ("angle", "rate", "p_a", "p_b")]
        slides, angle = event_driven(machine, dry, flow, start, 0.05, end)
        ours = slid(run)
        assert len(slides) >= 3
        assert len(ours) == len(slides)
        errors.append(np.abs(np.array(ours) - np.array(slides)).max())
        assert run["slew.angle"][-1] == pytest.approx(angle, abs=2.0 * dt)
    assert errors[0] < 4e-3
    assert errors[-1] < 0.5 * errors[0] or not COMPILED


def slid(run):
    """Times at which slides begin and end."""
    moves = (run["slew.rate"] != 0.0) & (run["time"] > 0.05)
    t, edges = run["time"], np.flatnonzero(moves[1:] != moves[:-1])
    begins = [t[k + 1] for k in edges if moves[k + 1]]
    ends = [t[k + 1] for k in edges if moves[k]]
    return [(a, b) for a, b in zip(begins, ends, strict=False)]


def event_driven(machine, dry, flow, start, t, end):
    """Slides of a slew on its own, and its last angle: all oil of the pump enters line A, line B drains through an orifice."""
    f = machine.function("slew")
    lever, line = f.drive.displacement * f.drive.gear_ratio, f.line
    ready = prepare_layout(machine, 1e-3, ("lift", "extend"))
    place = getattr(ready.module.position, "py_func", ready.module.position)
    functions = ready.module.Functions
    at = functions(*(g.initial.angle for g in machine.functions))
    inertia = place(at, functions(0.0, 0.0, 0.0), ready.plant).motion.mass.m11
    k_out, p_return = f.valve.outlet_positive[-1], machine.tank.return_pressure

    def drive(x):
        return lever * (x[2] - x[3])

    def slope(x, rate, torque):
        out = k_out * np.sqrt(max(x[3] - p_return, 0.0))
        return [
            rate,
            torque / inertia,
            (flow - lever * rate) / line.compliance_a,
            (lever * rate - out) / line.compliance_b,
        ]

    def sliding(_, x):
        level = dry.coulomb + (dry.static - dry.coulomb) * np.exp(-((x[1] / dry.stribeck) ** 2))
        return slope(x, x[1], drive(x) - level - dry.viscous * x[1])

    def holding(_, x):
        return slope(x, 0.0, 0.0)

    def stops(_, x):
        return x[1]

    def lets_go(_, x):
        return drive(x) - dry.static

    stops.terminal, stops.direction, lets_go.terminal, lets_go.direction = True, -1, True, 1
    x, slides, moving = np.array(start), [], False
    assert x[1] == 0.0
    for _ in range(100):
        found = solve_ivp(
            sliding if moving else holding, (t, end), x, method="LSODA", rtol=1e-8, atol=[1e-11, 1e-10, 1.0, 1.0],
            events=stops if moving else lets_go, max_step=0.01,
        )  # fmt: skip
        t, x = found.t[-1], found.y[:, -1]
        if found.status == 0:
            return slides, x[0]
        if moving:
            x[1], slides[-1] = 0.0, (slides[-1][0], t)
        else:
            x[1] = 1e-9
            slides.append((t, end))
        moving = not moving
    raise AssertionError("more than a hundred events")
