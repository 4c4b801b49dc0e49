"""Runs of machines that break: what they do is what a healthy machine does until then, and `Simulator.change` afterwards, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from polydraulic import (
    Deviation,
    Fault,
    InputError,
    Scenario,
    ScheduledFault,
    Simulator,
    load_machine,
    simulate,
    simulate_batch,
)
from polydraulic.flow import stiff_flow
from polydraulic.parameters.fault_catalogue import timed_faults
from polydraulic.parameters.faults import faulty_machine
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import random_operator
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.layout.runs import step_inputs

DT = 5e-3
ONE_OF_EACH = ("pump_worn", "leak_across", "spool_slow", "orifices_worn", "friction_high", "line_relief_low")


def broken_by_hand(machine, scenario, changes, n, flow="exact"):
    """States after each step of a machine that is moved by hand and changed at the given steps, to the machines there."""
    voltages = step_inputs(machine, scenario, np.arange(n) * DT)
    with Simulator(machine, flow, dt=DT) as sim:
        states = [sim.state.copy()]
        for k in range(n):
            if k in changes:
                sim.change({number.path: number.value for number in changes[k].numbers})
            sim.step(voltages[k])
            states.append(sim.state.copy())
    return np.array(states)


def state_of(run, machine):
    names = [f"{f}.{q}" for q in ("spool", "p_a", "p_b") for f in machine.names]
    joints = [
        f"{f.name}.{q}"
        for pair in (("angle", "position"), ("rate", "speed"))
        for f in machine.functions
        for q in pair
        if f"{f.name}.{q}" in run.names
    ]
    return run.matrix([*names, *joints])


@pytest.mark.parametrize(
    "name", ["cat215b", "wheel_loader", pytest.param("excavator_22t", marks=pytest.mark.slow_to_compile)]
)
def test_a_run_with_faults_is_a_healthy_one_until_they_begin_and_a_changed_one_after(name):
    machine = load_machine(name)
    scenario = random_operator(3, 2.0, functions=machine.names)
    faults = [
        f"{owner}.{what} from {0.5 + 0.1 * k} s"
        for k, what in enumerate(ONE_OF_EACH)
        for owner in [machine.circuits[0].name if what == "pump_worn" else machine.names[0]]
    ]
    faults[1] += " to 1.5 s"
    run = simulate(machine, "exact", scenario, dt=DT, faults=faults)
    healthy = simulate(machine, "exact", scenario, dt=DT)
    timed = timed_faults(machine, faults)
    begins = {100: 0.5, 120: 0.6, 140: 0.7, 160: 0.8, 180: 0.9, 200: 1.0, 300: 1.5}
    changes = {
        k: faulty_machine(machine, [(one.fault, one.since(t + 1e-9)) for one in timed]) for k, t in begins.items()
    }
    assert len(set(map(repr, changes.values()))) == 7
    by_hand, found = broken_by_hand(machine, scenario, changes, 400), state_of(run, machine)
    np.testing.assert_array_equal(found, by_hand)
    np.testing.assert_array_equal(found[:101], state_of(healthy, machine)[:101])
    assert (found[-1] != state_of(healthy, machine)[-1]).any()
    assert run.info["faults"] == [str(one) for one in timed]


def test_a_fault_that_grows_changes_the_machine_at_each_stage():
    machine = load_machine("wheel_loader")
    scenario = random_operator(3, 1.5, functions=machine.names)
    fault = ScheduledFault("work.pump_worn", 0.4, begin=0.2, growth=1.0)
    (timed,) = timed_faults(machine, [fault])
    steps = [50 + 10 * k for k in range(20)]
    changes = {k: faulty_machine(machine, [(timed.fault, k * DT - 0.2 + 1e-9)]) for k in steps}
    flows = [m.circuit("work").pump.flow / machine.circuit("work").pump.flow for m in changes.values()]
    np.testing.assert_allclose(flows, 1.0 - 0.02 * np.arange(1, 21))
    run = simulate(machine, "exact", scenario, dt=DT, faults=[fault])
    np.testing.assert_array_equal(state_of(run, machine), broken_by_hand(machine, scenario, changes, 300))


@pytest.mark.slow_to_compile
@pytest.mark.parametrize("flow", ["iterative", "stiff", "tlm"])
def test_other_flow_models_break_as_by_hand(flow):
    machine = load_machine("wheel_loader")
    scenario = random_operator(5, 1.0, functions=machine.names)
    fault = ScheduledFault("work.pump_relief_low", 0.3, begin=0.5)
    (timed,) = timed_faults(machine, [fault])
    changes = {100: faulty_machine(machine, [(timed.fault, 0.0)])}
    run = simulate(machine, flow, scenario, dt=DT, faults=[fault])
    np.testing.assert_array_equal(state_of(run, machine), broken_by_hand(machine, scenario, changes, 200, flow))


@pytest.mark.parametrize("flow", ["exact", pytest.param("iterative", marks=pytest.mark.slow_to_compile)])
def test_machines_of_a_batch_break_each_in_its_own_way(flow):
    """Side by side, with the bits of single runs; also where a payload comes and goes."""
    machine = load_machine("wheel_loader")
    scenario = random_operator(7, 1.0, functions=machine.names)
    loaded = replace(scenario, loads=Loads(payload=Payload((0.4, 0.8), (500.0, 0.0))))
    whole = replace(scenario, loads=Loads(payload=Payload((0.0,), (0.0,))))
    faults = [
        [],
        ["work.pump_worn 20 % from 0.303 s", "lift.leak_out 10 % from 0.5 s to 0.7 s"],
        ["tilt.spool_slow from 0.5 s", "tip.payload_unknown 300 kg from 0.2 s"],
        ["lift.friction_high from 0.1 s over 0.5 s"],
    ]
    inputs = [whole, whole, loaded, whole]
    batch = simulate_batch(machine, flow, inputs, dt=DT, keep=["rows", "range"], every=3, t_end=0.9, faults=faults)
    for i, (what, wrong) in enumerate(zip(inputs, faults, strict=True)):
        run = simulate(machine, flow, what, dt=DT, t_end=0.9, faults=wrong)
        for name in batch.names:
            np.testing.assert_array_equal(batch[name][i], run[name][::3], err_msg=f"{i} {name}")
            assert batch.final[i, batch.place(name)] == run[name][-1]
            assert batch.lowest[i, batch.place(name)] == run[name].min()
            assert batch.highest[i, batch.place(name)] == run[name].max()
    assert len(np.unique(batch.final[:, batch.place("lift.p_a")])) == 4
    same = simulate_batch(machine, flow, [whole, whole], dt=DT, t_end=0.9, faults=faults[1])
    assert same.final[0].tolist() == same.final[1].tolist()
    assert same.final[0, same.place("lift.p_a")] == batch.final[1, batch.place("lift.p_a")]


def test_faults_of_a_batch_are_one_list_or_one_each():
    machine = load_machine("wheel_loader")
    scenario = random_operator(7, 1.0, functions=machine.names)
    with pytest.raises(InputError, match="one list for all machines, or a list of lists"):
        simulate_batch(machine, "exact", scenario, faults=["work.pump_worn", []])
    with pytest.raises(InputError, match="2 machines, 1 inputs, 3 lists of faults"):
        simulate_batch([machine, machine], "exact", scenario, faults=[[], [], []])
    with pytest.raises(InputError, match="must be a list"):
        simulate_batch(machine, "exact", scenario, faults="work.pump_worn")
    late = Fault("late", "late", (Deviation("functions.lift.pilot.dead_time", "is", (0.1,)),))
    with pytest.raises(InputError, match=r"functions.lift.pilot.dead_time: in a batch dead times stay"):
        simulate_batch(machine, "exact", scenario, faults=[ScheduledFault(late, begin=0.5)])


@pytest.mark.slow_to_compile
def test_methods_with_their_own_steps_meet_the_same_faults():
    """Pilots, lines and the load at the tip change at the very time; the step of the fixed method converges to it."""
    machine = load_machine("wheel_loader")
    scenario = random_operator(11, 2.0, functions=machine.names)
    faults = ["lift.spool_slow from 0.5 s", "tilt.spool_weak from 0.8 s to 1.2 s", "lift.leak_out 10 % from 1 s"]
    faults += ["tip.payload_unknown 300 kg from 1.5 s"]
    run = simulate(machine, "exact", scenario, dt=DT, method="rosenbrock", rtol=1e-7, faults=faults)
    errors = []
    for dt in (1e-3, 5e-4):
        steps = simulate(machine, "exact", scenario, dt=dt, faults=faults)
        errors.append(
            [abs(steps[c][-1] - run[c][-1]) for c in ("lift.angle", "tilt.angle", "lift.spool", "tilt.spool")]
        )
    healthy = simulate(machine, "exact", scenario, dt=5e-4)
    assert abs(healthy["lift.angle"][-1] - run["lift.angle"][-1]) > 5e-3
    np.testing.assert_allclose(errors[1], 0.5 * np.array(errors[0]), rtol=0.1)  # of first order, whatever breaks


def test_a_low_relief_valve_is_seen_to_open_at_its_own_pressure():
    machine = load_machine("wheel_loader")
    scenario = Scenario("stall", 3.0, {"tilt": Constant(0.8)})
    run = simulate(machine, "exact", scenario, dt=DT, faults=["tilt.line_relief_low 60 % from 1 s"])
    low = 0.4 * machine.function("tilt").line.relief
    assert run["tilt.p_a"][run["time"] > 1.0].max() <= low
    opened = [t for t, who, what in run.info["events"] if (who, what) == ("tilt", "line A relief opens")]
    assert opened
    assert min(opened) == pytest.approx(1.0 + DT)


def test_what_a_run_does_not_know_is_said():
    machine = load_machine("wheel_loader")
    scenario = random_operator(7, 0.1, functions=machine.names)
    run = simulate(machine, "exact", scenario, faults=["lift.angle.bias", "work.pump_worn from 0.1 s"])
    assert run.info["doubtful_inputs"] == [
        "fault lift.angle.bias: sensors are no part of a run; `record` lets them err",
        "fault work.pump_worn: begins at 0.1 s, and the run ends at 0.1 s",
    ]
    with pytest.raises(InputError, match="made for the valves and pumps as they were"):
        simulate(machine, stiff_flow(machine), scenario, faults=["work.pump_worn from 0.05 s"])
    with pytest.raises(InputError, match="must be a list"):
        simulate(machine, "exact", scenario, faults="work.pump_worn")
