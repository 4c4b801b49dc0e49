"""A machine that is watched as C next to the package: the same bits with every row, alarms included."""

import ctypes
import subprocess

import numpy as np
import pytest

from helpers.watched_logs import held, known, log_of, made_networks
from polydraulic import InputError
from polydraulic.export.watch.source import export_watch, fault_names, watch_c
from polydraulic.watch.kernels.rows import JUDGED
from polydraulic.watch.watch import FaultWatch

CHECKED = ["-std=c99", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror"]
ALARM = JUDGED + 1


class CWatch:
    """The exported watch as a shared library."""

    def __init__(self, watch, folder):
        export_watch(watch, folder, name="w")
        library = folder / "w.so"
        subprocess.run(["gcc", *CHECKED, "-shared", "-fPIC", "w.c", "-o", library, "-lm"], cwd=folder, check=True)
        self.call, parts = ctypes.CDLL(str(library)), watch.judge_parts
        for name in ("w_share", "w_chance", "w_since", "w_certainty"):
            getattr(self.call, name).restype = ctypes.c_double
        self.call.w_fault_name.restype = self.call.w_kind_name.restype = ctypes.c_char_p
        self.live, self.work, self.marks = len(parts.live), len(parts.work), len(parts.marks)
        asked = sum(map(len, watch.asked[1:]))
        self.state = np.zeros(self.live + self.work + self.marks + asked)
        self.call.w_init(self.at)

    @property
    def at(self):
        return self.state.ctypes.data_as(ctypes.c_void_p)

    def update(self, time, row):
        return self.call.w_update(self.at, ctypes.c_double(time), row.ctypes.data_as(ctypes.c_void_p))

    def named(self):
        return self.call.w_fault_name(self.call.w_named(self.at)).decode()

    def opinion(self):
        kind = self.call.w_kind(self.at)
        return (
            self.call.w_kind_name(kind).decode(),
            self.call.w_certainty(self.at),
            bool(self.call.w_familiar(self.at)),
        )

    def has_the_bits_of(self, parts):
        marks = self.state[self.live + self.work :][: self.marks].view(np.int64)
        return np.array_equal(self.state[: self.live], parts.live) and np.array_equal(marks, parts.marks)


@pytest.fixture(scope="module")
def networks():
    return made_networks(known()[0].directions)


@pytest.fixture(scope="module")
def exported(networks, tmp_path_factory):
    of, expected = known()
    return CWatch(FaultWatch(of, expected, networks=networks), tmp_path_factory.mktemp("watch"))


@pytest.mark.parametrize(
    ("fault", "operator", "seconds", "stays"),
    [
        ("lift.leak_across 10 % from 20 s", 22, 80.0, None),
        ("lift.q_in.freeze from 20 s", 22, 80.0, None),
        ("tip.payload_unknown from 20 s", 22, 80.0, None),
        ("lift.leak_across 10 % from 20 s", 28, 130.0, (50.0, 90.0)),
        ("tilt.voltage.drift 4 % from 20 s over 200 s", 26, 160.0, None),
        ("tilt.voltage.bias from 20 s", 26, 80.0, None),
        pytest.param("tilt.voltage.drift 8 % from 20 s over 800 s", 26, 960.0, None, marks=pytest.mark.slow),
    ],
)
def test_every_row_has_the_bits_of_the_package(exported, networks, fault, operator, seconds, stays):
    of, expected = known()
    watch = FaultWatch(of, expected, networks=networks)
    parts, names = watch.judge_parts, fault_names(watch)
    log = log_of(of.machine, operator, seconds, [fault])
    log = held(log, "lift.q_in", *stays) if stays else log
    exported.call.w_init(exported.at)
    for time, row in zip(log["time"].tolist(), log.matrix(list(of.columns)), strict=True):
        row = np.ascontiguousarray(row)
        status, alarm = exported.update(time, row), watch.update(time, row)
        assert (status >= ALARM) == (alarm is not None)
        if alarm is not None:
            first = alarm.suspects[0] if alarm.suspects else None
            assert exported.named() == (first.name if first else "")
            assert exported.call.w_chance(exported.at) == (first.probability if first else 0.0)
            assert exported.opinion() == (tuple(alarm.opinion) if alarm.opinion else ("", 0.0, False))
    assert exported.has_the_bits_of(parts)
    first = watch.alarms[-1].suspects[0]
    assert first.name == fault.split()[0]
    assert (watch.alarms[-1].opinion is None) == first.name.endswith(".freeze")
    assert exported.call.w_harmless(exported.at) == int(first.harmless)
    assert exported.call.w_since(exported.at) == watch.alarms[-1].since
    shares = dict.fromkeys(names, 0.0)
    for d, share in zip(of.directions, watch.shares.tolist(), strict=True):
        shares[d.name] = max(shares[d.name], share)
    assert [exported.call.w_share(exported.at, k) for k in range(len(names))] == list(shares.values())
    could = [exported.call.w_could_show(exported.at, k) for k in range(len(names) + len(of.columns))]
    assert could == [int(f.could_show) for f in watch.findings()]
    for k, column in enumerate(of.columns, len(could)):  # a drift shows as the bias that it becomes
        bias = names.index(f"{column}.bias")
        assert exported.call.w_could_show(exported.at, k) == could[bias]
        assert exported.call.w_share(exported.at, k) == shares[f"{column}.bias"]
    beyond = len(could) + len(of.columns)
    assert exported.call.w_could_show(exported.at, beyond) == exported.call.w_could_show(exported.at, -1) == 0


@pytest.mark.slow
def test_flows_behind_a_crossover_have_the_bits_of_the_package(tmp_path):
    of, expected = known("cat215b_crossover")
    watch = FaultWatch(of, expected, networks=made_networks(of.directions))
    exported = CWatch(watch, tmp_path)
    log = log_of(of.machine, 22, 60.0, ["main_taking.pump_worn from 20 s"])
    for time, row in zip(log["time"].tolist(), log.matrix(list(of.columns)), strict=True):
        row = np.ascontiguousarray(row)
        assert (exported.update(time, row) >= ALARM) == (watch.update(time, row) is not None)
    assert exported.named() == "main_taking.pump_worn"
    assert exported.has_the_bits_of(watch.judge_parts)


def test_rows_that_are_no_numbers_are_told(exported):
    of, _ = known()
    exported.call.w_init(exported.at)
    assert exported.update(0.0, np.full(len(of.columns), np.nan)) == 2
    assert exported.call.w_named(exported.at) == -1
    assert exported.call.w_fault_name(-1) == exported.call.w_fault_name(10**6) == b""
    assert exported.opinion() == ("", 0.0, False)
    assert exported.call.w_kind_name(3) == b""


def test_a_watch_without_networks_has_none_of_their_functions():
    header, source = watch_c(FaultWatch(*known()), name="w").values()
    assert "w_kind" not in header
    assert "evaluate" not in source


def test_names_are_those_of_c():
    watch = FaultWatch(*known())
    assert "W_ROW_LIFT_SPOOL = " in watch_c(watch, name="w")["w.h"]
    assert "W_FAULT_LIFT_LEAK_ACROSS = " in watch_c(watch, name="w")["w.h"]
    with pytest.raises(InputError, match=r"name = 'a b': must be a C identifier, for example 'a_b'"):
        watch_c(watch, name="a b")
