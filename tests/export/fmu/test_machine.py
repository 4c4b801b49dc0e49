"""FMUs of the whole machine in FMPy: the bits of `simulate`, at any communication step."""

import numpy as np
import pytest

from helpers.stepped import stepped
from helpers.valves import changed
from polydraulic import load_scenario
from polydraulic.export.fmu.machine import export_machine_fmu
from polydraulic.export.fmu.machine_parameters import direct_parameters
from polydraulic.export.machine import machine_parts
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.operator import random_signals
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.thesis.excavator import LINKS, with_pumps

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
NAMES = [name for name, _ in machine_parts("cat215b", "exact").outputs]
N_OUT = len(NAMES)
TIP = 3  # columns of the effector, the last
OUT = list(range(3, 3 + N_OUT))
STATUS = 3 + N_OUT


class Digger:
    """One instance."""

    def __init__(self, path, folder, version=3, at=0.0, **start):
        description = fmpy.read_model_description(str(path))
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        fmpy.extract(str(path), unzipdir=str(folder))
        self.fmu = fmpy.instantiate_fmu(str(folder), description, fmi_type="CoSimulation")
        self.set = self.fmu.setReal if version == 2 else self.fmu.setFloat64
        self.get = self.fmu.getReal if version == 2 else self.fmu.getFloat64
        if version == 2:
            self.fmu.setupExperiment(startTime=at)
        self.set([self.reference[name] for name in start], list(start.values()))
        self.fmu.enterInitializationMode(**({} if version == 2 else {"startTime": at}))
        self.fmu.exitInitializationMode()

    def run(self, voltage, dt=5e-3):
        rows = np.empty((len(voltage) + 1, N_OUT))
        rows[0] = self.get(OUT)
        for k, v in enumerate(voltage.tolist()):
            self.set([0, 1, 2], v)
            self.fmu.doStep(k * dt, dt)
            rows[k + 1] = self.get(OUT)
        return rows


def expected(machine, flow, scenario, voltage=None):
    own = adapted(machine, scenario)
    if voltage is None:
        voltage = step_inputs(own, scenario, np.arange(round(scenario.duration / 5e-3)) * 5e-3)
    return stepped(own, flow, voltage, scenario.locked)[0], voltage


def same_bits(a, b):
    return np.array_equal(np.ascontiguousarray(a).view(np.int64), np.ascontiguousarray(b).view(np.int64))


def voltages(n, seed):
    signals = random_signals(seed, n * 5e-3, links=LINKS, limit=5.0, functions=LINKS)
    return np.column_stack([signals[link](np.arange(n) * 5e-3) for link in LINKS])


@pytest.fixture(scope="module")
def exact(machine, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exact")
    return export_machine_fmu(machine, "exact", folder / "digger.fmu", name="digger").main


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("flow", ["exact", "polynomial"])
@pytest.mark.parametrize("name", ["sine", "step", "pulse", "task"])
def test_all_scenarios_have_the_bits_of_simulate(machine, flow, name, version, tmp_path):
    scenario = load_scenario(name)
    own = adapted(machine, scenario)
    path = export_machine_fmu(own, flow, tmp_path / "m.fmu", version=version, locked=scenario.locked).main
    assert validation.validate_fmu(str(path)) == []
    rows, voltage = expected(machine, flow, scenario)
    assert same_bits(Digger(path, tmp_path / "in", version).run(voltage)[:, :-TIP], rows)


@pytest.mark.slow
@pytest.mark.parametrize("flow", ["exact", "polynomial"])
def test_100_000_steps_of_a_random_operator(machine, flow, tmp_path):
    path = export_machine_fmu(machine, flow, tmp_path / "m.fmu").main
    rows, voltage = expected(machine, flow, load_scenario("task"), voltages(100_000, 21))
    assert same_bits(Digger(path, tmp_path / "in").run(voltage)[:, :-TIP], rows)


def test_a_random_operator_has_the_bits_of_simulate(machine, exact, tmp_path):
    rows, voltage = expected(machine, "exact", load_scenario("task"), voltages(500, 4))
    assert same_bits(Digger(exact, tmp_path / "in").run(voltage)[:, :-TIP], rows)


def test_any_communication_step_makes_the_steps_that_are_due(exact, tmp_path):
    voltage = np.array([[2.0, -1.0, 3.0]])
    rows = Digger(exact, tmp_path / "a").run(np.tile(voltage, (60, 1)))
    for number, (step, count) in enumerate(((0.3, 1), (0.001, 300), (0.3 / 7, 7), (0.0075, 40))):
        digger = Digger(exact, tmp_path / str(number))
        digger.set([0, 1, 2], voltage[0].tolist())
        for k in range(count):
            digger.fmu.doStep(k * step, step)
            if step == 0.0075:
                assert same_bits(digger.get(OUT), rows[int((k + 1) * 1.5)])
        assert same_bits(digger.get(OUT), rows[-1])


@pytest.mark.parametrize("at", [-3e5, 0.1, 1711850398.0, 1.7e12])
def test_steps_are_counted_from_any_start(exact, at, tmp_path):
    voltage = voltages(300, 5)
    rows = Digger(exact, tmp_path / "0").run(voltage)
    points = at + np.arange(301) * 5e-3
    summed = np.concatenate([[at], at + np.cumsum(np.full(300, 5e-3))])  # as the importer adds up, rounding each time
    for number, ends in enumerate((points, summed, None)):
        digger, time = Digger(exact, tmp_path / str(number + 1), at=at), at
        for k, v in enumerate(voltage.tolist()):
            digger.set([0, 1, 2], v)
            time, step = (time, 5e-3) if ends is None else (float(ends[k]), float(ends[k + 1] - ends[k]))
            digger.fmu.doStep(time, step)
            time += step
            assert same_bits(digger.get(OUT), rows[k + 1]), (number, k)


def test_whole_numbers_of_steps_and_others_from_a_late_start(exact, tmp_path):
    voltage, at = np.array([[2.0, -1.0, 3.0]]), 1.7e9
    rows = Digger(exact, tmp_path / "a").run(np.tile(voltage, (600, 1)))
    for number, (step, made) in enumerate(((0.015, 3.0), (0.0075, 1.5), (1.0 / 60.0, 10.0 / 3.0))):
        digger = Digger(exact, tmp_path / str(number), at=at)
        digger.set([0, 1, 2], voltage[0].tolist())
        for k in range(150):
            begin, end = at + k * step, at + (k + 1) * step
            digger.fmu.doStep(begin, end - begin)
            assert same_bits(digger.get(OUT), rows[int((k + 1) * made + 1e-6)]), (step, k)


def test_times_too_large_to_count_steps_are_refused(exact, tmp_path):
    digger = Digger(exact, tmp_path / "a", at=1e15)
    with pytest.raises(fmpy.fmi1.FMICallException):
        digger.fmu.doStep(1e15, 5e-3)


def test_a_state_that_is_set_or_read_from_bytes_goes_on_with_the_same_bits(exact, tmp_path):
    voltage = voltages(400, 6)
    digger = Digger(exact, tmp_path / "a")
    digger.run(voltage[:200])
    state = digger.fmu.getFMUState()
    content = digger.fmu.serializeFMUState(state)

    def rest(digger):
        rows = []
        for k, v in enumerate(voltage[200:].tolist()):
            digger.set([0, 1, 2], v)
            digger.fmu.doStep((200 + k) * 5e-3, 5e-3)
            rows.append(digger.get(OUT))
        return np.array(rows)

    first = rest(digger)
    digger.fmu.setFMUState(state)
    assert same_bits(rest(digger), first)
    other = Digger(exact, tmp_path / "b")
    other.fmu.setFMUState(other.fmu.deserializeFMUState(content))
    assert same_bits(rest(other), first)
    digger.fmu.freeFMUState(state)


def test_parameters_are_those_of_a_changed_machine(machine, exact, tmp_path):
    other = changed(
        machine, "boom", friction={"viscous": 9e3, "static": 2.5e4}, line={"relief": 2.0e7, "leakage": 3e-12},
        initial={"angle": 0.3, "p_a": 4e6},
    )  # fmt: skip
    other = with_pumps(other, relief=1.5e7, flow=2e-3)
    rows, voltage = expected(other, "exact", load_scenario("task"), voltages(400, 9))
    digger = Digger(
        exact,
        tmp_path / "a",
        **{
            "functions.boom.friction.viscous": 9e3,
            "functions.boom.friction.static": 2.5e4,
            "functions.boom.line.relief": 2.0e7,
            "functions.boom.line.leakage": 3e-12,
            "functions.boom.initial.angle": 0.3,
            "functions.boom.initial.p_a": 4e6,
            **{f"circuits.{c}.pump.relief": 1.5e7 for c in ("boom", "series")},
            **{f"circuits.{c}.pump.flow": 2e-3 for c in ("boom", "series")},
        },
    )
    assert same_bits(digger.run(voltage)[:, :-TIP], rows)


def test_direct_parameters_leave_out_the_circuits_that_networks_were_trained_on(machine):
    exact, polynomial = ({p.name for p in direct_parameters(machine, flow)} for flow in ("exact", "polynomial"))
    circuits = {name for name in exact if name.startswith("circuits.") or name == "tank.return_pressure"}
    assert {"circuits.boom.pump.flow", "circuits.series.pump.relief"} < circuits
    assert polynomial == exact - circuits


def test_direct_parameters_leave_out_what_enters_other_numbers(machine):
    names = {parameter.name for parameter in direct_parameters(machine, "exact")}
    assert {"functions.boom.line.relief", "functions.swing.friction.viscous", "functions.stick.initial.angle"} <= names
    assert not names & {"links.boom.mass", "functions.boom.line.compliance_a", "functions.swing.pilot.time_constant"}
    assert {parameter.name for parameter in direct_parameters(machine, "exact")} <= {
        number.path for number in machine.numbers
    }
    limited = with_pumps(machine, torque_limit_enabled=True)
    assert "circuits.boom.pump.relief" in names
    assert "circuits.boom.pump.relief" not in {parameter.name for parameter in direct_parameters(limited, "exact")}


def test_what_is_not_finite_stops_the_run_and_says_so(exact, tmp_path):
    digger = Digger(exact, tmp_path / "a")
    digger.set([1], [float("nan")])
    with pytest.raises(fmpy.fmi1.FMICallException):
        digger.fmu.doStep(0.0, 0.01)
    again = Digger(exact, tmp_path / "b", **{"functions.boom.friction.viscous": float("nan")})
    with pytest.raises(fmpy.fmi1.FMICallException):
        again.fmu.doStep(0.0, 0.01)


def test_fmpy_simulates_it_with_recorded_inputs(machine, exact):
    rows, voltage = expected(machine, "exact", load_scenario("task"), voltages(200, 4))
    names = [("time", float), *((f"{link}.voltage", float) for link in LINKS)]
    inputs = np.array([(k * 5e-3, *v) for k, v in enumerate(voltage)], dtype=names)
    found = fmpy.simulate_fmu(str(exact), input=inputs, output_interval=5e-3, stop_time=0.995)
    for place, output in enumerate(NAMES[:-TIP]):
        assert np.abs(found[output] - rows[: len(found), place]).max() <= 1e-9 * np.abs(rows[:, place]).max() + 1e-300
    assert set(found["status"]) == {0.0}
