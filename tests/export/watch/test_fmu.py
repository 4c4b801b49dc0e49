"""A machine that is watched, as FMUs in FMPy: evidence and alarms of the package."""

import shutil

import pytest

from helpers.watched_logs import known, log_of
from polydraulic.export.watch.fmu import export_watch_fmu
from polydraulic.export.watch.source import fault_names
from polydraulic.watch.watch import FaultWatch

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


@pytest.mark.parametrize("version", [pytest.param(2, marks=pytest.mark.slow), 3])
def test_outputs_are_those_of_the_package(version, tmp_path):
    of, expected = known()
    watch, path = FaultWatch(of, expected), tmp_path / "w.fmu"
    export_watch_fmu(watch, path, version=version, name="w")
    assert validation.validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    places = {v.name: v.valueReference for v in description.modelVariables}
    fmpy.extract(str(path), unzipdir=str(tmp_path / "there"))
    fmu = fmpy.instantiate_fmu(str(tmp_path / "there"), description, fmi_type="CoSimulation")
    put, get = (fmu.setReal, fmu.getReal) if version == 2 else (fmu.setFloat64, fmu.getFloat64)
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode(**({} if version == 2 else {"startTime": 0.0}))
    fmu.exitInitializationMode()
    names, dt = fault_names(watch), of.shape.raster
    log = log_of(of.machine, 31, 30.0, ["lift.leak_across 10 % from 5 s"])
    sensors = [places[column] for column in of.columns]
    alarm = None
    for k, row in enumerate(log.matrix(list(of.columns))):
        alarm = watch.update(k * dt, row)
        put(sensors, row.tolist())
        fmu.doStep(k * dt, dt)
        if alarm is not None:
            break
    assert alarm is not None
    out = get([places[v] for v in ("alarm", "named", "chance", "since", "status")])
    assert out[0] == 1.0
    assert names[round(out[1]) - 1] == alarm.suspects[0].name
    assert out[2] == pytest.approx(alarm.suspects[0].probability, rel=1e-12)
    assert out[3:] == [pytest.approx(alarm.since, abs=1e-9), 0.0]
    first = [d.name for d in of.directions].index("work.pump_worn")
    assert get([places["work.pump_worn.evidence"]])[0] == pytest.approx(watch.shares[first], rel=1e-12)
