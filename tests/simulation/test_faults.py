"""Runs of machines that break: what they do is what a healthy machine does until then, and `Simulator.change` afterwards, bit for bit."""

import numpy as np
import pytest

from polydraulic import ScheduledFault, Simulator, load_machine, simulate
from polydraulic.parameters.fault_catalogue import timed_faults
from polydraulic.parameters.faults import faulty_machine
from polydraulic.parameters.scenario import random_operator
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


@pytest.mark.parametrize("name", ["cat215b", "wheel_loader", "excavator_22t"])
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


@pytest.mark.parametrize("flow", ["iterative", "stiff", "tlm"])
def test_other_flow_models_break_as_by_hand(flow):
    machine = load_machine("wheel_loader")
    scenario = random_operator(5, 1.0, functions=machine.names)
    fault = ScheduledFault("work.pump_relief_low", 0.3, begin=0.5)
    (timed,) = timed_faults(machine, [fault])
    changes = {100: faulty_machine(machine, [(timed.fault, 0.0)])}
    run = simulate(machine, flow, scenario, dt=DT, faults=[fault])
    np.testing.assert_array_equal(state_of(run, machine), broken_by_hand(machine, scenario, changes, 200, flow))
