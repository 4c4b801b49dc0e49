"""Dynamic models as C that runs: the bits of `free_run`, strengths included, and what has no answer."""

import ctypes
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from helpers.running_joints import KNOWN, NAMES, joint, joints, log
from polydraulic import InputError
from polydraulic.export import export_c
from polydraulic.export.c.run import run_of, try_run
from polydraulic.export.model_bundle import bundle
from polydraulic.networks import Lag, free_run

CHECKED = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-pedantic", "-Werror"]  # fmt: skip
INSIDE, OUTSIDE, NOT_A_NUMBER, TOO_FEW = range(4)
FIRST = 3  # the longest lag


class CRun:
    """An exported run as a shared library."""

    def __init__(self, models, folder, real="double"):
        export_c(models, folder, name="m", real=real)
        command = ["gcc", *CHECKED, "-shared", "-fPIC", "m.c", "m_run.c", "-o", "m.so", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        self.call = ctypes.CDLL(str(folder / "m.so"))
        self.call.m_run_strength.restype = ctypes.c_double
        self.state = np.zeros(200)  # more than enough
        self.begin()

    def begin(self):
        self.call.m_run_begin(self._at(self.state))

    def measured(self, row):
        return self.call.m_run_measured(self._at(self.state), self._at(row[:2].copy()), self._at(row[2:].copy()))

    def next(self, row):
        found = np.zeros(2)
        return self.call.m_run_next(self._at(self.state), self._at(row[:2].copy()), self._at(found)), found

    def strengths(self):
        return [self.call.m_run_strength(self._at(self.state), k, way) for k in (0, 1) for way in (0, 1)]

    def restarted(self, signals, horizon):
        """As `free_run` with a horizon: a copy runs on from the rows that are measured."""
        found = signals[:, 2:].copy()
        for t, row in enumerate(signals):
            if t >= FIRST and (t - FIRST) % horizon == 0:
                kept = self.state.copy()
                for k in range(t, min(t + horizon, len(signals))):
                    status, found[k] = self.next(signals[k])
                    assert status in (INSIDE, OUTSIDE)
                self.state[:] = kept
            assert self.measured(row) == INSIDE
        return found

    @staticmethod
    def _at(values):
        return values.ctypes.data_as(ctypes.c_void_p)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    return CRun(joints(), tmp_path_factory.mktemp("run"))


@pytest.mark.parametrize("horizon", [1, 40, 150])
def test_a_run_has_the_bits_of_the_package(exported, horizon):
    signals = log(600)
    exported.begin()
    found = exported.restarted(signals, horizon)
    wanted = free_run(joints(), dict(zip(NAMES, signals.T, strict=True)), horizon=horizon)
    assert np.array_equal(found, np.column_stack([wanted["boom"], wanted["stick"]]))
    assert 0.7 < min(exported.strengths()[:2]) < 0.95  # of the boom, which the filter has found weaker than its model
    assert exported.strengths()[2:] == [1.0, 1.0]


def test_what_has_no_answer_says_so(exported):
    signals = log(60)
    exported.begin()
    for t in range(FIRST):
        status, found = exported.next(signals[t])
        assert status == TOO_FEW
        assert np.isnan(found).all()
        assert exported.measured(signals[t]) == INSIDE
    assert exported.next(signals[FIRST])[0] == INSIDE
    assert exported.measured(signals[FIRST + 1]) == INSIDE  # behind an answer: anew
    assert exported.next(signals[FIRST + 2])[0] == TOO_FEW
    for part, value in ((0, np.nan), (3, np.inf)):
        exported.begin()
        for row in signals[:10]:
            exported.measured(row)
        bad = signals[10].copy()
        bad[part] = value
        assert exported.measured(bad) == NOT_A_NUMBER  # a gap
        assert exported.next(signals[11])[0] == TOO_FEW
    exported.begin()
    for row in signals[:10]:
        exported.measured(row)
    status, found = exported.next(np.array([np.nan, 0.0, 0.0, 0.0]))
    assert status == NOT_A_NUMBER
    assert np.isnan(found).all()
    exported.begin()
    for row in signals[:10]:
        exported.measured(row)
    assert exported.next(np.array([0.0, 9.0, 0.0, 0.0]))[0] == OUTSIDE


def test_in_float_it_runs_as_the_function_does(exported, tmp_path):
    single, signals = CRun(joints(), tmp_path, "float"), log(300)
    exported.begin()
    difference = np.abs(single.restarted(signals, 100) - exported.restarted(signals, 100)).max()
    assert 0.0 < difference < 1e-4
    assert "SELF_TEST" not in (tmp_path / "m_run.c").read_text()


# its self-test has 256 rows: a number that an exit code makes 0
LONG = joint("boom", [Lag("lift cmd", 3), Lag("boom", 1)], [0.1, 1.0], strength=replace(KNOWN, rows=114))


@pytest.mark.parametrize("models", [joints(), joints(raster=None), [joint("boom", [Lag("boom", 1)], [0.9])], [LONG]])
def test_the_self_test_passes_and_sees_another_bit(models, tmp_path):
    export_c(models, tmp_path, name="m")
    command = ["gcc", *CHECKED, "-DM_RUN_SELF_TEST", "m.c", "m_run.c", "-o", "m", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "m"], check=False).returncode == 0
    trial = try_run(bundle(models), run_of(bundle(models)))
    source = (tmp_path / "m_run.c").read_text()
    number = repr(float(trial.answers[-1, 0]))
    assert number in source
    (tmp_path / "m_run.c").write_text(source.replace(number, repr(float(np.nextafter(trial.answers[-1, 0], 9.0)))))
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "m"], check=False).returncode == len(trial.answers)


@pytest.mark.parametrize(
    "name", ["y", "own", "row", "states", "answer", "minimum", "WEAKEST", "Belief", "N_OUT", "N_IN"]
)
def test_a_model_may_have_any_name(name, tmp_path):
    header, source, _, run = export_c([joint(name, [Lag("x", 0), Lag(name, 1)], [0.1, 0.9])], tmp_path)
    named = header.stem
    command = ["gcc", *CHECKED, f"-D{named.upper()}_RUN_SELF_TEST", source, run, "-o", "m", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "m"], check=False).returncode == 0


def test_header_and_note_say_what_it_takes(tmp_path):
    made = export_c(joints(), tmp_path, name="m")
    assert [path.name for path in made] == ["m.h", "m.c", "m_run.h", "m_run.c"]
    assert "m_run.h runs row by row" in made.notes[-1]
    header = " ".join((tmp_path / "m_run.h").read_text().replace(" *", "").split())
    assert "inputs[0] lift cmd [V] inputs[1] tilt [V] outputs[0] boom [rad] outputs[1] stick [rad]" in header
    assert "boom [rad] reads lift cmd 3; boom 1 rows ago, and changes by -0.2 to 0.2 rad a row; its strength" in header
    assert "its strength differs from one time to another by 20.0% both ways" in header
    assert "#define M_RUN_INPUT_LIFT_CMD 0" in header
    assert "#define M_RUN_WARM_UP 3" in header
    assert "#define M_RUN_DT 0.05" in header
    assert "m_run.h stands beside it" in (tmp_path / "m.h").read_text()
    assert "_DT" not in "".join(map(str, export_c(joints(raster=None), tmp_path, name="n").main.read_text()))


def test_models_that_do_not_run_together_are_refused(tmp_path):
    first, second = joints()
    other = replace(second, dynamics=replace(second.dynamics, raster=0.1))
    with pytest.raises(InputError, match=r"rows 0.05, 0.1 s apart: export them apart"):
        export_c([first, other], tmp_path, name="m")
    clash = replace(first, output=replace(first.output, name="arm"), dynamics=replace(first.dynamics, lags=(Lag("lift cmd", 2), Lag("boom", 1))))  # fmt: skip
    with pytest.raises(
        InputError, match=r"'lift cmd\[t-3\]' is lift cmd\[t-2\] of one model and lift cmd\[t-3\] of another"
    ):
        export_c([first, clash], tmp_path, name="m")
    static = replace(second, dynamics=None)
    assert len(export_c([first, static], tmp_path / "static", name="m")) == 2
