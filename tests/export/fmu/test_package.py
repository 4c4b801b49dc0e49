"""FMUs of anything: parameters, a memory, no derivatives."""

import shutil

import fmpy
import pytest
from fmpy import validation

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
    if shutil.which("gcc") is None:
        pytest.skip("needs gcc")
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
