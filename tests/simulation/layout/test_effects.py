"""Backlash, hysteresis and flow forces in runs; all effects together have the bits of plain Python, lanes and C, and account for energy."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from helpers.small_crane import crane_text_with_effects, with_effects
from polydraulic import InputError, load_machine, simulate, simulate_batch
from polydraulic.flow.layout.model import exact_flow
from polydraulic.parameters.layout.parts import FlowForce
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.schema import Friction
from polydraulic.parameters.signals import Constant, Sine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout, start_from, start_vector
from polydraulic.simulation.layout.text import layout_text

NOTHING = FlowForce(1e20, 870.0, 0.5 * np.pi)  # jets that leave at right angles


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("effects") / "effects.toml"
    path.write_text(crane_text_with_effects(), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def full(file):
    return load_machine(file)


@pytest.fixture(scope="module")
def neutral(crane):
    """All that can be declared without a change of what moves."""
    return with_effects(crane, backlash=0.0, hysteresis=0.0, flow_force=NOTHING)


def changed(machine, name, effects=None, **parts):
    def new(f):
        f = f._replace(**parts)
        return f._replace(effects=f.effects._replace(**effects)) if effects else f

    return machine._replace(functions=tuple(new(f) if f.name == name else f for f in machine.functions))


def test_what_is_not_declared_is_not_in_the_text(crane, full, neutral):
    words = ("gap", "driven", "flow_shift", "rubbed", "half_play", "dry_friction")
    assert [word for word in words if word in layout_text(crane)] == []
    assert [word for word in words if word not in layout_text(full)] == []
    assert "rubbed" not in layout_text(neutral)
    assert columns_of(crane).n_state == 15
    assert columns_of(full).n_state == 24
    lone = changed(crane, "lift", {"hysteresis": 1e-4})
    assert [c.name for c in columns_of(lone).columns if c.name.endswith("driven")] == ["lift.driven"]


def test_effects_of_no_size_have_the_bits_of_a_machine_without_them(crane, neutral):
    operator = random_operator(3, 4.0, functions=crane.names)
    run, same = simulate(crane, "exact", operator, energy=True), simulate(neutral, "exact", operator, energy=True)
    for name in run.names:
        assert np.array_equal(run[name], same[name]), name
    for f in crane.names:
        assert np.array_equal(same[f"{f}.driven"], same[f"{f}.spool"])
        assert not same[f"{f}.gap"].any()


def test_orifices_follow_the_driven_spool_by_a_play_operator(neutral):
    wide = changed(neutral, "extend", {"hysteresis": 5e-4})
    run = simulate(wide, "exact", Scenario("to and fro", 4.0, {"extend": Sine(0.6, 3.0)}))
    driven, seen, place = run["extend.driven"], [], 0.0
    for x in driven:  # written out once more
        place = x - 2.5e-4 if place < x - 2.5e-4 else x + 2.5e-4 if place > x + 2.5e-4 else place
        seen.append(place)
    assert np.array_equal(run["extend.spool"], seen)
    assert np.ptp(driven) > 5e-3
    # the driven spool is the pilot's, whatever the orifices do
    free = simulate(neutral, "exact", Scenario("to and fro", 4.0, {"extend": Sine(0.6, 3.0)}))
    assert np.array_equal(driven, free["extend.driven"])


def test_a_spool_settles_where_spring_and_flow_force_balance(neutral):
    force = FlowForce(2e4, 870.0, np.radians(69.0))
    pushed = changed(neutral, "extend", {"flow_force": force})
    run = simulate(pushed, "exact", Scenario("out", 1.5, {"extend": Constant(0.6)}, locked=("slew", "lift")))
    f = pushed.function("extend")
    k = [np.interp(run["extend.spool"], f.valve.knots, curve) for curve in (f.valve.inlet, f.valve.outlet_positive)]
    drops = run["second.p_pump"] - run["extend.p_in"], run["extend.p_out"] - pushed.tank.return_pressure
    jets = sum(a * np.maximum(d, 0.0) for a, d in zip(k, drops, strict=True))
    shift = np.sqrt(2 * 870.0) * np.cos(np.radians(69.0)) * jets / 2e4
    assert shift[-1] > 1e-4
    assert run["extend.spool"][-1] + shift[-1] == pytest.approx(f.pilot.gain * 0.6, rel=1e-3)
    still = slice(100, None)
    # those of a step follow from pressures before and after it
    assert np.allclose(run["extend.flow_shift"][still], shift[still], rtol=0.1)


def test_a_flow_force_that_a_step_cannot_follow_is_refused(neutral):
    soft = changed(neutral, "extend", {"flow_force": FlowForce(3e2, 870.0, np.radians(69.0))})
    with pytest.raises(InputError, match=r"functions.extend.valve.flow_force: .* use dt = 0.00\d+ s or less") as error:
        simulate(soft, "exact", Scenario("out", 1.0, {}))
    most = float(re.search(r"use dt = (\S+) s", str(error.value))[1])
    prepare_layout(soft, 0.95 * most)
    with pytest.raises(InputError, match="flow_force"):
        prepare_layout(soft, 1.1 * most)


def test_the_step_that_a_flow_force_asks_for_is_followed_by_all_functions(neutral):
    softer = changed(neutral, "extend", {"flow_force": FlowForce(2e2, 870.0, np.radians(69.0))})
    for rate in (2e3, 3e2, 2.9e2, 2.8e2):
        soft = changed(softer, "slew", {"flow_force": FlowForce(rate, 870.0, np.radians(69.0))})
        with pytest.raises(InputError, match="which all functions can follow") as error:
            prepare_layout(soft, 0.1)
        said = float(re.search(r"use dt = (\S+) s", str(error.value))[1])
        prepare_layout(soft, said)
        with pytest.raises(InputError, match="flow_force"):
            prepare_layout(soft, 1.1 * said)


@pytest.mark.slow_to_compile
def test_runge_kutta_is_the_limit_of_short_steps_with_hysteresis_and_flow_forces(crane):
    """Of first order the steps, of second or better what they come to, with spools that turn back and are pushed."""
    pushed = with_effects(crane, hysteresis=2e-4, flow_force=FlowForce(4e4, 870.0, np.radians(69.0)))
    scenario = Scenario(
        "to and fro", 0.48, {"slew": Sine(0.5, 12.0), "lift": Sine(0.6, 10.0), "extend": Sine(0.5, 9.0)}
    )

    def run(method, dt):
        return simulate(pushed, "exact", scenario, method=method, dt=dt, raster=8e-3)

    def off(found, keys):
        return max(np.abs(found[key] - tight[key]).max() for key in keys)

    tight = run("rk4", 5e-4)
    spools, joints = [f"{f}.spool" for f in crane.names], ["slew.angle", "lift.angle", "extend.position"]
    coarse, fine, rk4 = run("semi-implicit", 4e-3), run("semi-implicit", 1e-3), run("rk4", 2e-3)
    for keys in (spools, joints):
        assert 3.0 < off(coarse, keys) / off(fine, keys) < 5.5
        assert off(rk4, keys) < 0.05 * off(fine, keys)
    for f in crane.names:
        assert np.abs(tight[f"{f}.driven"] - tight[f"{f}.spool"]).max() == pytest.approx(1e-4, rel=1e-9)
        assert tight[f"{f}.flow_shift"].max() > 1e-6


@pytest.mark.slow_to_compile
def test_the_reference_is_the_limit_of_short_steps_with_flow_forces(crane):
    """Spools that are pushed end its steps at their knots, which are not known in advance."""
    pushed = with_effects(crane, flow_force=FlowForce(4e4, 870.0, np.radians(69.0)))
    scenario = Scenario(
        "to and fro", 0.48, {"slew": Sine(0.5, 12.0), "lift": Sine(0.6, 10.0), "extend": Sine(0.5, 9.0)}
    )
    tight = simulate(pushed, "exact", scenario, method="reference", rtol=1e-9, dt=8e-3)
    coarse, fine = (simulate(pushed, "exact", scenario, method="rk4", dt=dt, raster=8e-3) for dt in (2e-3, 5e-4))
    assert tight.names == fine.names

    def off(run, quantity):
        return max(np.abs(run[f"{f}.{quantity}"] - tight[f"{f}.{quantity}"]).max() for f in crane.names)

    shifts = [tight[f"{f}.flow_shift"].max() for f in crane.names]
    assert max(shifts) > 5e-5
    for quantity in ("spool", "flow_shift", "p_a"):
        assert off(fine, quantity) < 0.6 * off(coarse, quantity)
    assert max(off(fine, "spool"), off(fine, "flow_shift")) < 1e-3 * max(shifts)
    free = simulate(crane, "exact", scenario, method="reference", rtol=1e-9, dt=8e-3)
    opens = [
        next(t for t, where, what in run.info["events"] if (where, what) == ("lift", "valve opens"))
        for run in (free, tight)
    ]
    assert opens[0] == pytest.approx(opens[1], abs=1e-9)  # until then nothing flows, and nothing pushes
    assert tight.info["events_located"] > 0


@pytest.mark.slow_to_compile
def test_spools_that_are_known_in_advance_lag_behind_their_drivers(crane):
    lagging = with_effects(crane, hysteresis=2e-4)
    scenario = Scenario(
        "to and fro", 0.48, {"slew": Sine(0.5, 12.0), "lift": Sine(0.6, 10.0), "extend": Sine(0.5, 9.0)}
    )
    known = simulate(lagging, "exact", scenario, method="rosenbrock", rtol=1e-6, dt=8e-3)
    steps = simulate(lagging, "exact", scenario, method="rk4", dt=1e-3, raster=8e-3)
    assert known.names == steps.names
    for f in crane.names:
        assert np.abs(known[f"{f}.spool"] - known[f"{f}.driven"]).max() == pytest.approx(1e-4, rel=1e-9)
        for quantity, far in (("spool", 2e-7), ("driven", 2e-8)):
            assert np.abs(known[f"{f}.{quantity}"] - steps[f"{f}.{quantity}"]).max() < far
    for joint in ("slew.angle", "lift.angle", "extend.position"):
        assert np.abs(known[joint] - steps[joint]).max() < 2e-3 * np.ptp(steps[joint])


def test_what_does_not_know_an_effect_says_which(crane):
    sticky = changed(crane, "lift", {"sticks": True})
    for method in ("rk4", "rosenbrock", "reference"):
        with pytest.raises(InputError, match=rf"functions.lift.friction.sticks: method '{method}' does not know it"):
            simulate(sticky, "exact", "random:1:1", method=method)
    pushed = changed(crane, "extend", {"flow_force": NOTHING})
    served = "use 'semi-implicit' or 'rk4' or 'reference', or leave it out"
    with pytest.raises(InputError, match=f"valve.flow_force: .* {served}"):
        simulate(pushed, "exact", "random:1:1", method="rosenbrock")
    both = changed(pushed, "extend", {"hysteresis": 1e-4})
    with pytest.raises(InputError, match="functions.extend: method 'reference' knows .* but not both of one valve"):
        simulate(both, "exact", "random:1:1", method="reference")
    networks = exact_flow(pushed)._replace(name="polynomial", kernels="networks")
    with pytest.raises(
        InputError, match="functions.extend.valve.flow_force: flow 'polynomial' does not know the inlets"
    ):
        prepare_layout(pushed, 5e-3, flow=networks)


@pytest.mark.parametrize("flow", ["exact", pytest.param("iterative", marks=pytest.mark.slow_to_compile)])
def test_a_flow_models_own_flows_push_its_spools(full, flow):
    run = simulate(full, flow, random_operator(2, 1.0, functions=full.names))
    f = full.function("slew")
    travel, force = run["slew.spool"], f.effects.flow_force
    k_in = np.interp(np.abs(travel), f.valve.knots, f.valve.inlet)
    out = (f.valve.outlet_positive, f.valve.outlet_negative)
    k_out = np.where(travel >= 0.0, *(np.interp(np.abs(travel), f.valve.knots, curve) for curve in out))
    jets = sum(q**2 / np.maximum(k, 1e-300) for q, k in ((run["slew.q_in"], k_in), (run["slew.q_out"], k_out)))
    shift = np.sqrt(2.0 * force.density) * np.cos(force.jet_angle) * jets / force.spring_rate
    assert shift.max() > 1e-5
    assert np.allclose(run["slew.flow_shift"][1:], shift[1:], rtol=1e-9, atol=1e-15)


def free_slew(machine, play):
    """A slew without friction and leakage, whose valve is shut."""
    f = machine.function("slew")
    return changed(
        machine,
        "slew",
        {"backlash": play},
        friction=Friction(0.0, 0.0, 0.0, 0.02, 0.05),
        line=f.line._replace(leakage=0.0),
        initial=f.initial._replace(p_a=100e5, p_b=100e5),
    )


@pytest.mark.parametrize("play", [0.0, 0.01, 0.04])
def test_a_joint_flies_through_its_play_from_one_oil_spring_to_the_other(neutral, play):
    machine, dt, speed = free_slew(neutral, play), 5e-4, 0.05
    ready = prepare_layout(machine, dt, ("lift", "extend"))
    place = columns_of(machine).place
    start = ready.start.copy()
    start[place["slew.rate"]] = speed
    n = 8000
    rows = np.empty((n + 1, len(place)))
    counts, memory = np.zeros(2, dtype=np.int64), np.zeros(ready.n_memory)
    done = ready.module.run(ready.valves, memory, ready.plant, start, np.zeros((n, 3)), 1, rows, counts)
    assert done == n
    f = machine.function("slew")
    lever = f.drive.displacement * f.drive.gear_ratio
    stiffness = lever**2 * (1.0 / f.line.compliance_a + 1.0 / f.line.compliance_b)
    position = getattr(ready.module.position, "py_func", ready.module.position)
    at = ready.module.Functions(*(g.initial.angle for g in machine.functions))
    inertia = position(at, ready.module.Functions(0.0, 0.0, 0.0), ready.plant).motion.mass.m11
    rate, angle = rows[:, place["slew.rate"]], rows[:, place["slew.angle"]]
    turns = np.flatnonzero((rate[1:] < 0.0) & (rate[:-1] >= 0.0))
    period = np.diff(turns).mean() * dt
    assert len(turns) >= 2
    assert period == pytest.approx(2.0 * np.pi * np.sqrt(inertia / stiffness) + 2.0 * play / speed, rel=5e-3)
    assert np.abs(rate).max() == pytest.approx(speed, rel=5e-3)  # no energy comes or goes
    assert np.ptp(angle) == pytest.approx(play + 2.0 * speed * np.sqrt(inertia / stiffness), rel=5e-3)
    assert np.abs(rows[:, place["slew.gap"]]).max() <= 0.5 * play


def test_the_energy_account_closes_with_all_effects(full):
    gaps = []
    for dt in (4e-3, 2e-3, 1e-3):
        scenario = random_operator(2, 1.6, functions=full.names)
        run = simulate(full, "exact", scenario, dt=dt, energy=True)
        assert not [event for event in run.info["events"] if "stop" in event[2]]
        power = sum(run[f"{f}.joint_power"] - run[f"{f}.friction_power"] for f in full.names)
        stored = run["energy.kinetic"] + run["energy.potential"]
        put_in = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * dt)])
        gaps.append(np.abs(stored - stored[0] - put_in).max() / np.ptp(stored))
        for f in full.names:
            joint = "extend.speed" if f == "extend" else f"{f}.rate"
            assert run[f"{f}.friction_power"].min() >= 0.0
            assert not run[f"{f}.friction_power"][run[joint] == 0.0].any()
    assert gaps[0] < 0.1
    assert gaps[2] < 0.5 * gaps[0]


@pytest.mark.slow_to_compile
def test_lanes_have_the_bits_of_single_runs(full):
    heavy = full._replace(links=tuple(link._replace(mass=1.3 * link.mass) for link in full.links))
    machines = [full, heavy, full]
    operators = [random_operator(seed, 1.0, functions=full.names) for seed in range(3)]
    t_end = 0.3 if numba.config.DISABLE_JIT else 1.0  # in plain Python a block takes 64 times as long as a machine
    for used in (machines, full):
        batch = simulate_batch(used, "exact", operators, t_end=t_end, keep=["rows"])
        assert {"lift.driven", "lift.flow_shift", "lift.gap"} <= set(batch.names)
        for i in (1, 2):
            run = simulate(machines[i] if used is machines else full, "exact", operators[i], t_end=t_end)
            for name in batch.names:
                assert np.array_equal(batch[name][i], run[name]), (i, name)


PLAIN = """
import sys
import numpy as np
from polydraulic import load_machine, random_operator, simulate

plant = load_machine(sys.argv[1])
run = simulate(plant, "exact", random_operator(2, 2.0, functions=plant.names))
np.save(sys.argv[2], np.column_stack([run[name] for name in run.names]))
"""


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_plain_python_has_the_bits_of_compiled_code(file, full, tmp_path):
    there: Path = tmp_path / "plain.npy"
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, "-c", PLAIN, str(file), str(there)], check=True, env=environment)
    run = simulate(full, "exact", random_operator(2, 2.0, functions=full.names))
    assert np.load(there).tobytes() == np.column_stack([run[name] for name in run.names]).tobytes()


def test_a_state_that_is_measured_begins_as_a_run_does(full):
    start, place = start_vector(full), columns_of(full).place
    assert start_from(full, start[:15]).tolist() == start.tolist()
    moving = start[:15].copy()
    moving[0], moving[7], moving[12] = 2e-3, 5e6, 0.1  # slew's spool, lift's pressure at B, slew's rate
    begun = start_from(full, moving)
    assert begun[:15].tolist() == moving.tolist()
    assert (begun[place["slew.driven"]], begun[place["lift.driven"]]) == (2e-3, 0.0)
    assert begun[place["lift.gap"]] == -0.5 * full.function("lift").effects.backlash  # pushed the other way
    assert begun[place["slew.flow_shift"]] == 0.0


@pytest.mark.slow_to_compile
def test_a_batch_goes_on_from_states_with_what_effects_keep(full):
    volts = np.full((40, 3), 0.7)
    whole = simulate_batch(full, "exact", volts, keep=["rows"])
    columns = [column.name for column in columns_of(full).columns[: columns_of(full).n_state]]
    middle = np.array([whole[name][0, 20] for name in columns])
    after = simulate_batch(full, "exact", volts[20:], x0=middle, keep=["rows"])
    for name in after.names:
        assert np.array_equal(after[name][0, 1:], whole[name][0, 21:]), name
    with pytest.raises(InputError, match=rf"x0 has shape \(15,\): .* \({len(middle)},\)"):
        simulate_batch(full, "exact", volts, x0=middle[:15])
