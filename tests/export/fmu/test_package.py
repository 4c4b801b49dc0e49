"""FMUs of anything: parameters, a memory, no derivatives."""

import fmpy
import numpy as np
import pytest
from fmpy import fmi2, validation
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from polydraulic.export.fmu.description import FmuDescription, FmuVariable
from polydraulic.export.fmu.package import write_fmu

EQUATIONS = """
static void fmu_start(const double *v, double *memory) { memory[0] = v[2]; }
static void fmu_outputs(double *v, const double *memory) { v[3] = v[1] * memory[0]; }
static int fmu_advance(double *v, double *memory, double from, double to)
{
    memory[0] += v[0] * (to - from);
    return memory[0] < 10.0;
}
static void fmu_partials(const double *v, const double *memory, double *partials)
{
    (void)v;
    (void)memory;
    (void)partials;
}
"""
WHAT = FmuDescription(
    "integrator",
    (
        FmuVariable("u", "input", "m3/s", 1.0),
        FmuVariable("gain", "parameter", "1", 2.0),
        FmuVariable("first", "fixed parameter", "m", 0.5),
        FmuVariable("y", "output", "m", dependencies=()),
    ),
    model_exchange=False,
    derivatives=False,
    step=0.1,
    memory=1,
)


@pytest.mark.parametrize("version", [2, 3])
def test_a_memory_goes_on_through_steps_and_failure_is_told(version, tmp_path):
    path = str(write_fmu(WHAT, {"equations.h": EQUATIONS}, tmp_path / "i.fmu", version=version, page="").main)
    assert validation.validate_fmu(path) == []
    found = fmpy.simulate_fmu(path, stop_time=1.0, output_interval=0.1)
    assert found["y"] == pytest.approx(2.0 * (0.5 + found["time"]))
    other = fmpy.simulate_fmu(path, stop_time=1.0, output_interval=0.25, start_values={"gain": 1.0, "first": 3.0})
    assert other["y"] == pytest.approx(3.0 + other["time"])
    description = fmpy.read_model_description(path)
    assert description.modelExchange is None
    assert description.outputs[0].dependencies == []
    assert [v.name for v in description.initialUnknowns[0].dependencies] == ["gain", "first"]
    with pytest.raises(Exception, match="DoStep"):
        fmpy.simulate_fmu(path, stop_time=20.0, output_interval=1.0)
    fmu = fmpy.instantiate_fmu(fmpy.extract(path, unzipdir=str(tmp_path / "in")), description)
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    put = fmu.setReal if version == 2 else fmu.setFloat64
    put([1], [3.0])
    for reference in (2, 3, 99):  # a fixed parameter, an output, nothing
        with pytest.raises(Exception, match="fmi"):
            put([reference], [1.0])
    fmu.freeInstance()


def started(path, folder, version, at=0.0, log=None, stop=None):
    """One instance that has begun at a time, and its function to read."""
    description = fmpy.read_model_description(str(path))
    fmpy.extract(str(path), unzipdir=str(folder))
    options = {} if log is None else {"callbacks": callbacks(version, log)} if version == 2 else {"logMessage": log}
    if version == 2:
        fmu = FMU2Slave(
            guid=description.guid, unzipDirectory=str(folder), instanceName="one", modelIdentifier="integrator"
        )
        fmu.instantiate(**options)
        fmu.setupExperiment(startTime=at, stopTime=stop)
        fmu.enterInitializationMode()
    else:
        fmu = FMU3Slave(
            guid=description.instantiationToken,
            unzipDirectory=str(folder),
            instanceName="one",
            modelIdentifier="integrator",
        )
        fmu.instantiate(**options)
        fmu.enterInitializationMode(startTime=at, stopTime=stop)
    fmu.exitInitializationMode()
    return fmu, fmu.getReal if version == 2 else fmu.getFloat64


def callbacks(version, log):
    """Those of FMPy with a logger of one's own."""
    made = fmi2.fmi2CallbackFunctions()
    made.logger = fmi2.fmi2CallbackLoggerTYPE(log)
    made.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmi2.calloc)
    made.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmi2.free)
    return made


@pytest.fixture(scope="module")
def integrators(tmp_path_factory):
    folder = tmp_path_factory.mktemp("integrators")
    return {
        version: write_fmu(WHAT, {"equations.h": EQUATIONS}, folder / f"i{version}.fmu", version=version, page="").main
        for version in (2, 3)
    }


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("at", [0.0, 1.7e9])
def test_steps_that_leave_a_gap_or_have_no_length_are_errors_that_are_told_and_do_nothing(
    version, at, integrators, tmp_path
):
    told = []

    def log(*message):
        told.append(message[-1])

    fmu, read = started(integrators[version], tmp_path / "in", version, at, log)
    fmu.doStep(at, 0.5)
    for point, step, why in [
        (at, 0.5, "not where the last step ended"),
        (at + 0.501, 0.5, "not where the last step ended"),
        (at + 0.5, -0.5, "finite and not negative"),
        (at + 0.5, np.inf, "finite and not negative"),
        (at + 0.5, np.nan, "finite and not negative"),
        (np.nan, 0.5, "finite times"),
        (-np.inf, 0.5, "finite times"),
    ]:
        with pytest.raises(fmpy.fmi1.FMICallException, match="DoStep"):
            fmu.doStep(point, step)
        assert why in str(told.pop()), (point, step)
        assert told == []
        assert read([3]) == [2.0 * (0.5 + 0.5)]
    state = fmu.getFMUstate() if version == 2 else fmu.getFMUState()
    fmu.doStep(at + 0.5, 0.25)
    (fmu.setFMUstate if version == 2 else fmu.setFMUState)(state)  # which takes the time back
    fmu.doStep(at + 0.5, 0.5)
    assert read([3]) == [2.0 * (0.5 + 1.0)]
    assert told == []
    fmu.freeInstance()


@pytest.mark.parametrize("version", [2, 3])
def test_the_first_step_begins_at_the_start_which_is_a_finite_time(version, integrators, tmp_path):
    fmu, _ = started(integrators[version], tmp_path / "a", version, 5.0)
    with pytest.raises(fmpy.fmi1.FMICallException, match="DoStep"):
        fmu.doStep(0.0, 0.5)
    with pytest.raises(fmpy.fmi1.FMICallException, match="etupExperiment|nterInitialization"):
        started(integrators[version], tmp_path / "b", version, np.nan)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("stop", "allowed"), [(4.9, False), (np.nan, False), (5.0, True), (6.0, True), (np.inf, True)])
def test_a_stop_before_the_start_is_an_error_that_is_told(version, stop, allowed, integrators, tmp_path):
    told = []

    def begin():
        return started(
            integrators[version], tmp_path / "in", version, 5.0, lambda *message: told.append(message[-1]), stop
        )

    if allowed:
        begin()[0].freeInstance()
        assert told == []
    else:
        with pytest.raises(fmpy.fmi1.FMICallException, match="etupExperiment|nterInitialization"):
            begin()
        assert "the stop time lies before the start time" in str(told.pop())


@pytest.mark.parametrize("version", [2, 3])
def test_points_that_are_rounded_differently_are_no_gap(version, integrators, tmp_path):
    fmu, read = started(integrators[version], tmp_path / "in", version, 1.7e9)
    for k in range(400):
        fmu.doStep(1.7e9 + k * 0.005, 0.005)
    assert read([3]) == pytest.approx([2.0 * (0.5 + 2.0)], rel=1e-4)
