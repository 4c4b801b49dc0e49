import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.parameters.deviations import PAYLOAD, Deviation, Fault, TimedFault
from polydraulic.parameters.faults import (
    faulty_column,
    faulty_numbers,
    faulty_parts,
    faulty_readings,
    first_step,
    stages,
    unknown_payload,
    unread_faults,
)


@pytest.fixture(scope="module")
def loader():
    return load_machine("wheel_loader")


FLOW = "circuits.work.pump.flow"
WORN = Fault("worn", "worn pump", (Deviation(FLOW, "times", (0.9, 0.8), (1.0, 3.0)),))


def test_a_number_changes_with_time_and_is_healthy_before(loader):
    healthy = loader.circuit("work").pump.flow
    found = [faulty_numbers(loader, [(WORN, t)])[FLOW] for t in (-1.0, 0.5, 1.0, 2.9, 3.0, 99.0)]
    assert found == [healthy, healthy, *[0.9 * healthy] * 2, *[0.8 * healthy] * 2]
    assert [stages([(WORN, t)]) for t in (0.0, 1.0, 3.0)] == [(0,), (1,), (2,)]


def test_faults_of_one_number_act_one_after_the_other(loader):
    half, more = (Fault(how, how, (Deviation(FLOW, how, (x,)),)) for how, x in (("times", 0.5), ("plus", 1e-4)))
    healthy = loader.circuit("work").pump.flow
    assert faulty_numbers(loader, [(half, 0.0), (more, 0.0)])[FLOW] == 0.5 * healthy + 1e-4
    assert faulty_numbers(loader, [(more, 0.0), (half, 0.0)])[FLOW] == 0.5 * (healthy + 1e-4)
    assert faulty_numbers(loader, [(half, 0.0), (half, 0.0)])[FLOW] == 0.25 * healthy


def test_a_machine_is_in_parts_between_its_changes(loader):
    hung = Fault("hung", "hung", (Deviation(PAYLOAD, "plus", (300.0,)),))
    parts = faulty_parts(loader, [TimedFault(WORN, 1.0, 5.0), TimedFault(hung, 4.0)], 100.0)
    flow = loader.circuit("work").pump.flow
    found = [(p.begin, p.machine.circuit("work").pump.flow, p.payload) for p in parts]
    assert found == [(0.0, flow, 0.0), (2.0, 0.9 * flow, 0.0), (4.0, 0.8 * flow, 300.0), (5.0, flow, 300.0)]
    assert parts[0].machine == loader
    assert unknown_payload([(hung, 0.0), (hung, 2.0), (hung, -1.0)]) == 600.0
    assert faulty_parts(loader, [TimedFault(WORN, 200.0)], 100.0) == [(0.0, loader, 0.0)]


def test_what_happens_acts_in_the_next_whole_step():
    assert [first_step(t, 5e-3, 100) for t in (0.0, 0.3, 0.3 + 1e-4, 7.0)] == [0, 60, 61, 100]


def test_a_sensor_reads_what_is_not():
    stuck = Fault("stuck", "stuck", readings=(Deviation("lift.angle", "is", (0.3,), (2.0,)),))
    read = {"lift.angle": 0.1, "tilt.angle": 0.2}
    assert faulty_readings(read, [(stuck, 1.9)], {})["lift.angle"] == 0.1
    assert faulty_readings(read, [(stuck, 2.0)], {}) == {"lift.angle": 0.3, "tilt.angle": 0.2}


def test_a_frozen_sensor_holds_its_last_reading():
    frozen, held = Fault("frozen", "frozen", readings=(Deviation("a", "holds", (0.0,)),)), {}
    found = [
        faulty_readings({"a": x}, [(frozen, t)], held)["a"]
        for x, t in ((1.0, -1.0), (2.0, 0.0), (3.0, 1.0), (4.0, -1.0))
    ]
    assert (found, held) == ([1.0, 2.0, 2.0, 4.0], {})
    time, values, held = np.arange(5.0), 10.0 * np.arange(5.0), {}
    of = TimedFault(frozen, 2.0, 4.0)
    np.testing.assert_array_equal(faulty_column("a", time, values, [of], held), [0.0, 10.0, 10.0, 10.0, 40.0])
    np.testing.assert_array_equal(faulty_column("b", time, values, [of], held), values)
    np.testing.assert_array_equal(faulty_column("a", time, values, [of.after(4.0)], held), values)
    assert held == {}
    faulty_column("a", time, values, [TimedFault(frozen, 2.0)], held)
    np.testing.assert_array_equal(faulty_column("a", time, values, [TimedFault(frozen, -4.0)], held), np.full(5, 10.0))


def test_a_sensor_that_freezes_again_holds_what_it_reads_then():
    frozen = Fault("frozen", "frozen", readings=(Deviation("a", "holds", (0.0,)),))
    times, time, values, held = (
        [TimedFault(frozen, 2.0, 4.0), TimedFault(frozen, 6.0)],
        np.arange(8.0),
        np.arange(8.0),
        {},
    )
    assert faulty_column("a", time, values, times, held).tolist() == [0.0, 1.0, 1.0, 1.0, 4.0, 5.0, 5.0, 5.0]
    later = [one.after(10.0) for one in times]
    assert faulty_column("a", time, 20.0 + values, later, held).tolist() == [5.0] * 8
    anew = [TimedFault(frozen, 0.0, 1.0)]
    assert faulty_column("a", time, 40.0 + values, anew, held).tolist() == [40.0 + k for k in range(8)]


def test_a_column_that_is_off_is_off_while_the_fault_is_there():
    time, values = np.arange(5.0), 10.0 * np.arange(5.0)
    drift = Fault("drift", "drift", readings=(Deviation("a", "plus", (1.0, 2.0), (0.0, 1.0)),))
    np.testing.assert_array_equal(
        faulty_column("a", time, values, [TimedFault(drift, 1.0, 4.0)], {}), [0, 11, 22, 32, 40]
    )
    double = Fault("double", "double", readings=(Deviation("a", "times", (2.0,)),))
    both = [TimedFault(double, 3.0), TimedFault(drift, 4.0)]
    np.testing.assert_array_equal(faulty_column("a", time, values, both, {}), [0, 10, 20, 60, 81])
    assert unread_faults(both, ["b"]) == ["a", "a"]
    assert unread_faults(both, ["a"]) == []


def test_what_the_machine_does_not_have_is_named(loader):
    with pytest.raises(InputError, match="no number 'circuits.work.pump.flaw'"):
        faulty_numbers(loader, [(Fault("x", "x", (Deviation("circuits.work.pump.flaw", "times", (1.0,)),)), 0.0)])
    with pytest.raises(InputError, match="numbers of a machine are constant"):
        faulty_numbers(loader, [(Fault("x", "x", (Deviation(FLOW, "holds", (1.0,)),)), 0.0)])
    with pytest.raises(InputError, match="no reading 'x.y'"):
        faulty_readings({}, [(Fault("x", "x", readings=(Deviation("x.y", "times", (1.0,)),)), 0.0)], {})
    with pytest.raises(InputError, match=r"with the faults x: .*circuits.work.pump.flow = -.*must be above 0"):
        faulty_parts(loader, [TimedFault(Fault("x", "x", (Deviation(FLOW, "times", (-1.0,)),)), 0.0)], 1.0)
