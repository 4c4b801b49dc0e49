"""Dynamic models as FMUs that run: the bits of `free_run`, and steps that have no answer."""

import numpy as np
import pytest

from helpers.running_joints import NAMES, joint, joints, log
from polydraulic.export import export_fmu
from polydraulic.export.c.run import run_of
from polydraulic.export.fmu.run import describe_run
from polydraulic.export.model_bundle import bundle
from polydraulic.networks import Lag, free_run

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
DT, MEASURED = 0.05, 300


class Running:
    """An FMU as FMPy runs it."""

    def __init__(self, path, folder, version=3):
        assert validation.validate_fmu(str(path)) == []
        description = fmpy.read_model_description(str(path))
        self.places = {v.name: v.valueReference for v in description.modelVariables}
        fmpy.extract(str(path), unzipdir=str(folder))
        self.fmu = fmpy.instantiate_fmu(str(folder), description, fmi_type="CoSimulation")
        self.set = self.fmu.setReal if version == 2 else self.fmu.setFloat64
        self.read = self.fmu.getReal if version == 2 else self.fmu.getFloat64
        if version == 2:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.rows = 0

    def row(self, values, measuring):
        names = [*NAMES[:2], *(f"{name}.measured" for name in NAMES[2:]), "measuring"]
        self.set([self.places[name] for name in names], [*values, float(measuring)])
        self.fmu.doStep(self.rows * DT, DT)
        self.rows += 1
        return self.get("boom", "stick")

    def get(self, *names):
        return self.read([self.places[name] for name in names])


@pytest.mark.parametrize("version", [pytest.param(2, marks=pytest.mark.slow), 3])
def test_a_run_has_the_bits_of_the_package(version, tmp_path):
    made = export_fmu(joints(), tmp_path / "m.fmu", version=version)
    assert "runs by itself, a row every 0.05 s, behind 3 rows or more" in made.notes[0]
    running, signals = Running(made.main, tmp_path / "there", version), log(MEASURED + 100)
    for k, row in enumerate(signals[:MEASURED]):
        assert running.row(row, True) == row[2:].tolist()
        assert running.get("status") == [3.0 if k < 2 else 0.0]
    up, down = running.get("boom.strength_upwards", "boom.strength_downwards")
    assert 0.7 < min(up, down) < 0.95
    found = np.array([running.row(row, False) for row in signals[MEASURED:]])
    # the second window of a horizon begins where the first 300 answers end
    known = dict(zip(NAMES, signals.T, strict=True))
    wanted = free_run(joints(), known, horizon=MEASURED - 3)
    assert np.array_equal(found, np.column_stack([wanted["boom"], wanted["stick"]])[MEASURED:])
    assert running.get("boom.strength_upwards", "boom.strength_downwards") == [up, down]


def test_a_state_that_is_stored_looks_ahead_again_and_again(tmp_path):
    running = Running(export_fmu(joints(), tmp_path / "m.fmu").main, tmp_path / "there")
    signals = log(60)
    for row in signals[:40]:
        running.row(row, True)
    kept, at = running.fmu.getFMUState(), running.rows
    ahead = [running.row(row, False) for row in signals[40:50]]
    running.fmu.setFMUState(kept)
    running.rows = at
    assert [running.row(row, False) for row in signals[40:50]] == ahead
    running.row(signals[50], True)  # anew
    assert running.get("status") == [3.0]


@pytest.mark.filterwarnings("ignore")
def test_a_step_without_an_answer_fails_and_says_why(tmp_path, capfd):
    path = export_fmu(joints(), tmp_path / "m.fmu").main
    running = Running(path, tmp_path / "few")
    assert running.get("boom", "status") == [0.0, 3.0]
    running.row(log(2)[0], True)
    with pytest.raises(fmpy.fmi1.FMICallException):
        running.row(log(2)[1], False)
    assert "there is no answer: 3 rows must have been measured before" in capfd.readouterr().out
    running = Running(path, tmp_path / "gap")
    for row in log(10):
        running.row(row, True)
    running.row([np.nan, 0.0, 0.0, 0.0], True)
    assert running.get("status") == [2.0]
    with pytest.raises(fmpy.fmi1.FMICallException):
        running.row(log(10)[3], False)


def test_without_a_raster_it_is_the_function_of_lagged_values(tmp_path):
    made = export_fmu(joints(raster=None), tmp_path / "m.fmu")
    names = [v.name for v in fmpy.read_model_description(str(made.main)).modelVariables]
    assert "lift cmd[t-3]" in names
    assert made.notes[-1].startswith("an FMU of models whose raster is known runs by itself")
    assert made.notes[0].startswith("dynamic, a function of lagged values")


def test_what_outputs_hold_is_said_and_has_no_limits_where_it_may_be_measured():
    whole = bundle(joints())
    told = {v.name: v for v in describe_run(whole, run_of(whole)).variables}
    assert [(told[name].low, told[name].high) for name in NAMES[2:]] == [(None, None)] * 2
    assert (told["lift cmd"].low, told["lift cmd"].high, told["lift cmd"].unit) == (-1.5, 1.5, "V")
    assert told["boom.strength_upwards"].description.startswith("How strong the joint is upwards")
    assert told["boom.strength_downwards"].description.startswith("How strong the joint is downwards")


def test_names_that_are_taken_and_models_without_inputs():
    whole = bundle([joint("measuring", [Lag("measuring", 1)], [0.9])])
    what = describe_run(whole, run_of(whole))
    assert [v.name for v in what.variables] == ["measuring.measured", "measuring", "measuring_", "status"]
    assert what.of_kind("output") == [2, 3]
