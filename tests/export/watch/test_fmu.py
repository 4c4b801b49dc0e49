"""A machine that is watched, as FMUs in FMPy: evidence and alarms of the package."""

import pytest

from helpers.watched_logs import known, log_of, made_networks
from polydraulic.export.watch.fmu import export_watch_fmu
from polydraulic.export.watch.source import all_names
from polydraulic.watch.watch import FaultWatch

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")


class Running:
    """An FMU as FMPy runs it."""

    def __init__(self, path, folder, version):
        assert validation.validate_fmu(str(path)) == []
        description = fmpy.read_model_description(str(path))
        self.places = {v.name: v.valueReference for v in description.modelVariables}
        fmpy.extract(str(path), unzipdir=str(folder))
        self.fmu = fmpy.instantiate_fmu(str(folder), description, fmi_type="CoSimulation")
        self.put = self.fmu.setReal if version == 2 else self.fmu.setFloat64
        self.get = self.fmu.getReal if version == 2 else self.fmu.getFloat64
        if version == 2:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode(**({} if version == 2 else {"startTime": 0.0}))
        self.fmu.exitInitializationMode()

    def outputs(self, *names):
        return self.get([self.places[name] for name in names])


@pytest.mark.parametrize("version", [pytest.param(2, marks=pytest.mark.slow), 3])
def test_outputs_are_those_of_the_package(version, tmp_path):
    of, expected = known()
    watch, path = FaultWatch(of, expected, networks=made_networks(of.directions)), tmp_path / "w.fmu"
    export_watch_fmu(watch, path, version=version, name="w")
    running, names, dt = Running(path, tmp_path / "there", version), all_names(watch), of.shape.raster
    sensors, kinds = [running.places[column] for column in of.columns], watch.networks.kinds
    log, named = log_of(of.machine, 26, 130.0, ["tilt.voltage.drift 4 % from 20 s over 200 s"]), set()
    for k, row in enumerate(log.matrix(list(of.columns))):
        alarm = watch.update(k * dt, row)
        running.put(sensors, row.tolist())
        running.fmu.doStep(k * dt, dt)
        if alarm is None:
            continue
        is_alarm, number, *numbers, kind, certainty, familiar, status = running.outputs(
            "alarm", "named", "chance", "since", "kind", "certainty", "familiar", "status"
        )
        first, opinion = alarm.suspects[0], alarm.opinion
        named.add(first.name)
        assert (is_alarm, status) == (1.0, 0.0)
        assert names[round(number) - 1] == first.name
        assert numbers == [first.probability, alarm.since]
        assert (kinds[round(kind) - 1], certainty, bool(familiar)) == tuple(opinion)
    assert "tilt.voltage.drift" in named
    first = [d.name for d in of.directions].index("work.pump_worn")
    assert running.outputs("work.pump_worn.evidence")[0] == watch.shares[first]
