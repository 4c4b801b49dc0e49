import pytest

from polydraulic import InputError, load_machine
from polydraulic.parameters.faults import Deviation, Fault, faulty_numbers, faulty_readings, stages, usual_faults


@pytest.fixture(scope="module")
def loader():
    return load_machine("wheel_loader")


FLOW = "circuits.work.pump.flow"


def test_a_number_changes_with_time_and_is_healthy_before(loader):
    worn = Fault("worn", "worn pump", (Deviation(FLOW, "times", (0.9, 0.8), (1.0, 3.0)),))
    healthy = loader.circuit("work").pump.flow
    found = [faulty_numbers(loader, {worn: t})[FLOW] for t in (-1.0, 0.5, 1.0, 2.9, 3.0, 99.0)]
    assert found == [healthy, healthy, *[0.9 * healthy] * 2, *[0.8 * healthy] * 2]
    assert [stages({worn: t}) for t in (0.0, 1.0, 3.0)] == [(0,), (1,), (2,)]


def test_faults_of_one_number_act_one_after_the_other(loader):
    half, more = (Fault(how, how, (Deviation(FLOW, how, (x,)),)) for how, x in (("times", 0.5), ("plus", 1e-4)))
    healthy = loader.circuit("work").pump.flow
    assert faulty_numbers(loader, {half: 0.0, more: 0.0})[FLOW] == 0.5 * healthy + 1e-4
    assert faulty_numbers(loader, {more: 0.0, half: 0.0})[FLOW] == 0.5 * (healthy + 1e-4)


def test_a_sensor_reads_what_is_not():
    stuck = Fault("stuck", "stuck", readings=(Deviation("lift.angle", "is", (0.3,), (2.0,)),))
    assert faulty_readings({"lift.angle": 0.1, "tilt.angle": 0.2}, {stuck: 1.9})["lift.angle"] == 0.1
    assert faulty_readings({"lift.angle": 0.1, "tilt.angle": 0.2}, {stuck: 2.0}) == {
        "lift.angle": 0.3,
        "tilt.angle": 0.2,
    }


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ({"amount": (1.0, 2.0)}, "one amount per time"),
        ({"amount": (float("nan"),)}, "finite"),
        ({"amount": (1.0, 2.0), "time": (1.0, 1.0)}, "rise"),
        ({"amount": (1.0,), "time": (-1.0,)}, "rise"),
        ({"amount": (1.0,), "how": "divided"}, "must be one of"),
    ],
)
def test_what_is_no_deviation_is_refused(what, says):
    with pytest.raises(InputError, match=says):
        Deviation(**({"of": FLOW, "how": "times"} | what))


def test_what_the_machine_does_not_have_is_named(loader):
    with pytest.raises(InputError, match="no number 'circuits.work.pump.flaw'"):
        faulty_numbers(loader, {Fault("x", "x", (Deviation("circuits.work.pump.flaw", "times", (1.0,)),)): 0.0})
    with pytest.raises(InputError, match="no reading 'x.y'"):
        faulty_readings({}, {Fault("x", "x", readings=(Deviation("x.y", "times", (1.0,)),)): 0.0})


@pytest.mark.parametrize("name", ["cat215b", "cat215b_crossover", "excavator_22t", "loader_crane", "wheel_loader"])
def test_every_machine_can_have_the_usual_faults(name):
    machine = load_machine(name)
    faults = usual_faults(machine)
    assert len({fault.name for fault in faults}) == len(faults)
    read = {f"{name}.angle": 0.1 for name in machine.names}
    for fault in faults:
        changed = machine.with_values(faulty_numbers(machine, {fault: 0.0})) != machine
        assert changed != (faulty_readings(read, {fault: 0.0}) != read), fault.name
