"""A machine that is watched as C next to the package: the same bits with every row, alarms included."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from helpers.watched_logs import held, known, log_of
from polydraulic import InputError
from polydraulic.export.watch.source import export_watch, fault_names, watch_c
from polydraulic.watch.kernels.rows import JUDGED
from polydraulic.watch.watch import FaultWatch

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
CHECKED = ["-std=c99", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror"]
ALARM = JUDGED + 1


class CWatch:
    """The exported watch as a shared library."""

    def __init__(self, watch, folder):
        export_watch(watch, folder, name="w")
        library = folder / "w.so"
        subprocess.run(["gcc", *CHECKED, "-shared", "-fPIC", "w.c", "-o", library, "-lm"], cwd=folder, check=True)
        self.call, parts = ctypes.CDLL(str(library)), watch.judge_parts
        for name in ("w_share", "w_chance", "w_since"):
            getattr(self.call, name).restype = ctypes.c_double
        self.call.w_fault_name.restype = ctypes.c_char_p
        self.live = len(parts.live)
        self.state = np.zeros(self.live + len(parts.work) + len(parts.marks))
        self.call.w_init(self.at)

    @property
    def at(self):
        return self.state.ctypes.data_as(ctypes.c_void_p)

    def update(self, time, row):
        return self.call.w_update(self.at, ctypes.c_double(time), row.ctypes.data_as(ctypes.c_void_p))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    of, expected = known()
    return CWatch(FaultWatch(of, expected), tmp_path_factory.mktemp("watch"))


@pytest.mark.parametrize(
    ("fault", "stays"),
    [
        ("lift.leak_across 10 %", None),
        ("lift.q_in.freeze", None),
        ("tip.payload_unknown", None),
        ("lift.leak_across 10 %", (50.0, 90.0)),
    ],
)
def test_every_row_has_the_bits_of_the_package(exported, fault, stays):
    of, expected = known()
    watch = FaultWatch(of, expected)
    parts, names = watch.judge_parts, fault_names(watch)
    log = log_of(of.machine, 28 if stays else 22, 130.0 if stays else 80.0, [f"{fault} from 20 s"])
    log = held(log, "lift.q_in", *stays) if stays else log
    exported.call.w_init(exported.at)
    for time, row in zip(log["time"].tolist(), log.matrix(list(of.columns)), strict=True):
        row = np.ascontiguousarray(row)
        status, alarm = exported.update(time, row), watch.update(time, row)
        assert (status >= ALARM) == (alarm is not None)
        if alarm is not None:
            name = exported.call.w_fault_name(exported.call.w_named(exported.at)).decode()
            assert name.removesuffix(".bias") == alarm.suspects[0].name.removesuffix(".drift").removesuffix(".bias")
    assert np.array_equal(exported.state[: exported.live], parts.live)
    assert np.array_equal(exported.state[exported.live + len(parts.work) :].view(np.int64), parts.marks)
    first = watch.alarms[-1].suspects[0]
    named = exported.call.w_named(exported.at)
    assert exported.call.w_fault_name(named).decode() == first.name == fault.split()[0]
    assert exported.call.w_harmless(exported.at) == int(first.harmless)
    assert exported.call.w_chance(exported.at) == pytest.approx(first.probability, rel=1e-12)
    assert exported.call.w_since(exported.at) == watch.alarms[-1].since
    shares = dict.fromkeys(names, 0.0)
    for d, share in zip(of.directions, watch.shares.tolist(), strict=True):
        shares[d.name] = max(shares[d.name], share)
    assert [exported.call.w_share(exported.at, k) for k in range(len(names))] == list(shares.values())
    could = [exported.call.w_could_show(exported.at, k) for k in range(len(names) + len(of.columns))]
    assert could == [int(f.could_show) for f in watch.findings()]
    assert exported.call.w_could_show(exported.at, len(could)) == exported.call.w_could_show(exported.at, -1) == 0


def test_rows_that_are_no_numbers_are_told(exported):
    of, _ = known()
    exported.call.w_init(exported.at)
    assert exported.update(0.0, np.full(len(of.columns), np.nan)) == 2
    assert exported.call.w_named(exported.at) == -1
    assert exported.call.w_fault_name(-1) == exported.call.w_fault_name(10**6) == b""


def test_names_are_those_of_c():
    watch = FaultWatch(*known())
    assert "W_ROW_LIFT_SPOOL = " in watch_c(watch, name="w")["w.h"]
    assert "W_FAULT_LIFT_LEAK_ACROSS = " in watch_c(watch, name="w")["w.h"]
    with pytest.raises(InputError, match=r"name = 'a b': must be a C identifier, for example 'a_b'"):
        watch_c(watch, name="a b")
