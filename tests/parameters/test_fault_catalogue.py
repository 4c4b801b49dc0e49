"""The catalogue: of every shipped machine all that it lists can be had, and what it does not have is refused by name."""

import pytest

from polydraulic import InputError, ScheduledFault, fault_catalogue, load_machine
from polydraulic.parameters.deviations import PAYLOAD, STAGES, Deviation, Fault, TimedFault
from polydraulic.parameters.fault_catalogue import as_list, cockpit_faults, reading_spans, timed_faults
from polydraulic.parameters.faults import faulty_numbers, faulty_parts
from polydraulic.parameters.load import machine_names


@pytest.mark.parametrize("name", machine_names())
def test_every_machine_can_have_its_faults_at_all_their_usual_sizes(name):
    machine = load_machine(name)
    faults, spans = fault_catalogue(machine), reading_spans(machine)
    assert len({kind.name for kind in faults}) == len(faults)
    healthy = {number.path: number.value for number in machine.numbers}
    for kind in faults:
        for size in kind.sizes or (None,):
            fault = kind.fault(size, growth=0.0)
            assert bool(fault.numbers) != bool(fault.readings)
            assert all(d.of in spans for d in fault.readings)
            part = faulty_parts(machine, [TimedFault(fault, 0.0)], 1.0)[0]
            assert (part.machine != machine or part.payload > 0.0) == bool(fault.numbers), kind.name
            values = faulty_numbers(machine, [(fault, 0.0)])
            zeros = [path for path, value in values.items() if value == healthy[path] != 0.0]
            assert not zeros, kind.name
    assert {kind.name for kind in cockpit_faults(machine)} < {kind.name for kind in faults}


def kind_of(machine, name):
    return next(kind for kind in fault_catalogue(machine) if kind.name == name)


@pytest.mark.parametrize(
    ("name", "deviations"),
    [
        ("boom.pump_worn", [("circuits.boom.pump.flow", "times", 0.95)]),
        ("boom.pump_relief_low", [("circuits.boom.pump.relief", "times", 0.9)]),
        ("boom.spool_slow", [("functions.boom.pilot.time_constant", "times", 2.0)]),
        ("boom.line_relief_low", [("functions.boom.line.relief", "times", 0.9)]),
        ("boom.air_in_lines", [(f"functions.boom.line.compliance_{side}", "times", 2.0) for side in "ab"]),
        ("boom.torque_limit_off", [("circuits.boom.pump.torque_limit_start", "is", 1e9)]),
        ("tip.payload_unknown", [(PAYLOAD, "plus", 740.0)]),
    ],
)
def test_the_usual_size_is_the_one_that_counts(name, deviations):
    fault = kind_of("excavator_22t", name).fault()
    assert [(d.of, d.how, pytest.approx(d.amount[0])) for d in fault.numbers] == deviations


def test_a_leak_is_stated_at_200_bar_and_a_bias_in_the_range_of_its_sensor():
    machine = load_machine("wheel_loader")
    (leak,) = kind_of(machine, "lift.leak_across").fault().numbers
    assert leak.amount[0] * 200e5 == pytest.approx(0.02 * machine.circuit("work").pump.flow)
    (bias,) = kind_of(machine, "lift.angle.bias").fault().readings
    low, high = machine.function("lift").stops
    assert bias == Deviation("lift.angle", "plus", (0.02 * (high - low),))


def test_growth_is_in_equal_stages():
    (worn,) = kind_of("wheel_loader", "work.pump_worn").fault(0.2, growth=10.0).numbers
    assert worn.time[:2] == (0.5, 1.0)
    assert (len(worn.time), worn.time[-1]) == (STAGES, 10.0)
    assert worn.amount[:2] == (pytest.approx(0.99), pytest.approx(0.98))
    assert worn.amount[-1] == 0.8
    assert kind_of("wheel_loader", "lift.p_a.drift").fault().readings[0].time[-1] == 600.0


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ("work.pump_wurn", "no fault 'work.pump_wurn'; near it: work.pump_worn"),
        ("work.pump_worn 95 %", "size = 95 %: must be above 0 % and at most 90 %"),
        ("work.pump_worn 300 kg", "size = '300 kg': must be a number with its unit, for example 10 %"),
        ("lift.angle.bias 200 %", "must be from -100 % to 100 %"),
        ("tip.payload_unknown -5 kg", "size = -5 kg: must be above 0 kg"),
        ("lift.p_a.freeze 5 %", "is there or not"),
        ("work.torque_limit_off over 5 s", "is there or not"),
        ("lift.spool_sticks", r"no number functions.lift.valve.hysteresis; declare it in its file"),
        (Fault("mine", "mine", (Deviation("gravity.x", "is", (1.0,)),)), "no number 'gravity.x'"),
    ],
)
def test_what_the_machine_cannot_have_is_refused_by_name(fault, says):
    machine = load_machine("wheel_loader")
    with pytest.raises(InputError, match=says):
        faulty_parts(machine, timed_faults(machine, [fault]), 10.0)


def test_a_pump_without_torque_limit_cannot_lose_it():
    with pytest.raises(
        InputError, match=r"pump of boom has no torque limit \(circuits.boom.pump.torque_limit_enabled = false\)"
    ):
        timed_faults(load_machine("cat215b"), ["boom.torque_limit_off"])


def test_a_spool_that_may_stick_has_a_fault_that_lets_it():
    machine = load_machine("wheel_loader")
    lift = machine.function("lift")
    able = lift._replace(effects=lift.effects._replace(hysteresis=0.0))
    able = machine._replace(functions=tuple(able if f is lift else f for f in machine.functions))
    (part,) = faulty_parts(able, timed_faults(able, ["lift.spool_sticks 10 %"]), 1.0)
    assert part.machine.function("lift").effects.hysteresis == pytest.approx(0.1 * lift.valve.knots[-1])


def test_faults_are_a_list():
    with pytest.raises(InputError, match=r"must be a list, for example \['work.pump_worn'\]"):
        as_list("work.pump_worn")
    (timed,) = timed_faults(load_machine("wheel_loader"), [ScheduledFault("work.pump_worn", begin=3.0)])
    assert str(timed) == "work.pump_worn from 3 s: pump of work worn: its flow is 5 % low"
    assert timed_faults(load_machine("wheel_loader"), [timed]) == (timed,)
