"""Several files of one campaign as one log."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure import import_log, suggest_channels
from polydraulic.measure.channels import channel_map
from polydraulic.measure.formats.campaign import _agree, _Part, expand
from polydraulic.measure.formats.log import Log, LogBlock, Signal
from polydraulic.tables import read_table

MAP = {
    "raster": "10 ms",
    "channel": [
        {"source": "time", "role": "time"},
        {"source": "p", "role": "input", "unit": "bar", "range": [50, 150]},
    ],
}


def put(folder, name, begin, n=200, unit="bar", stamp=False):
    t = begin + 0.01 * np.arange(n)
    times = [f"2024-03-31T10:00:{x:06.3f}Z" if stamp else f"{x:.2f}" for x in t]
    text = "".join(f"{a},{100 + 10 * np.sin(x):.3f}\n" for a, x in zip(times, t, strict=True))
    (folder / name).write_text(f"time,p [{unit}]\n{text}")
    return folder / name


def joined(folder, *names):
    found = import_log([folder / name for name in names], channel_map(MAP), folder / "t.parquet")
    return found, read_table(folder / "t.parquet")


@pytest.mark.parametrize("stamp", [False, True])
def test_files_are_joined_in_the_order_of_their_times(tmp_path, stamp):
    put(tmp_path, "late.csv", 5.0, stamp=stamp), put(tmp_path, "early.csv", 0.0, stamp=stamp)
    found, table = joined(tmp_path, "late.csv", "early.csv")
    time = table["time"] - table["time"][0]
    assert time == pytest.approx(np.concatenate([0.01 * np.arange(200), 5.0 + 0.01 * np.arange(200)]), abs=1e-6)
    assert table["p"] == pytest.approx(1e5 * (100 + 10 * np.sin(time)), rel=1e-5)
    assert [(f.kind, f.rows) for f in found.findings] == [("gap", [(201, 201)])]
    assert (found.n_segment, found.source.name) == (2, "early.csv, late.csv")


def test_files_that_overlap_are_named_and_read_once(tmp_path):
    put(tmp_path, "a.csv", 0.0), put(tmp_path, "b.csv", 1.5)
    found, table = joined(tmp_path, "a.csv", "b.csv")
    assert (
        found.findings.of("files overlap")[0].detail
        == "b.csv begins before a.csv ends: what was recorded already is left out"
    )
    assert table["time"] == pytest.approx(0.01 * np.arange(350))


def put_mdf(folder, name, started, begin, n=200, seed=0):
    """An MDF file that says when it began; its values are those of the time `begin`, or of another day."""
    from asammdf import MDF, Signal

    t = 0.01 * np.arange(n)
    value = 100.0 + 10.0 * np.sin((begin + t) * (1.0 + 0.37 * seed)) + seed
    with MDF(version="4.10") as file:
        file.append([Signal(value, t, "bar", "p")])
        file.start_time = datetime.fromtimestamp(1.7e9 + started, UTC)
        return file.save(folder / name)


def test_mdf_files_whose_stated_times_overlap_are_named(tmp_path):
    given = channel_map({"raster": "10 ms", "channel": [{"source": "p", "role": "input", "unit": "bar"}]})
    a, b = put_mdf(tmp_path, "a.mf4", 0.0, 0.0), put_mdf(tmp_path, "b.mf4", 1.5, 1.5)
    found = import_log([b, a], given, tmp_path / "t.parquet")
    named = {f.kind: f.detail for f in found.findings if f.channel == ""}
    assert named["files overlap"] == "b.mf4 begins before a.mf4 ends: what was recorded already is left out"
    assert named.keys() == {"files overlap", "overlap", "time repeats"}
    table = read_table(tmp_path / "t.parquet")
    assert table["time"] == pytest.approx(0.01 * np.arange(350))
    assert table["p"] == pytest.approx(1e5 * (100.0 + 10.0 * np.sin(table["time"])), rel=1e-9)

    saved = put_mdf(tmp_path, "saved.mf4", 1.5, 0.0, seed=3)  # a converter gave it the time when it was written
    found = import_log([saved, a], given, tmp_path / "t.parquet")
    named = {f.kind: f.detail for f in found.findings if f.channel == ""}
    assert named["files overlap"].startswith(
        "saved.mf4 begins before a.mf4 ends: they hold other values at these times"
    )
    assert named["files begin anew"] == "saved.mf4, a.mf4, 60 s apart"
    assert (found.n_row, found.n_segment) == (400, 2)


def test_a_file_that_repeats_is_left_out(tmp_path):
    (tmp_path / "b.csv").write_bytes(put(tmp_path, "a.csv", 0.0).read_bytes())
    found, table = joined(tmp_path, "a.csv", "b.csv")
    assert [(f.kind, f.detail) for f in found.findings] == [("file repeats", "b.csv is a.csv")]
    assert len(table) == 200


def test_clocks_that_begin_anew_are_put_one_behind_the_other(tmp_path):
    put(tmp_path, "b.csv", 0.0), put(tmp_path, "a.csv", 0.0, n=150)
    found, table = joined(tmp_path, "b.csv", "a.csv")
    assert found.findings.of("files begin anew")[0].detail == "b.csv, a.csv, 60 s apart"
    assert (len(table), found.n_segment) == (350, 2)
    assert table["time"][200] == pytest.approx(61.99)


def test_units_that_differ_are_named(tmp_path):
    put(tmp_path, "a.csv", 0.0), put(tmp_path, "b.csv", 5.0, unit="psi")
    found, _ = joined(tmp_path, "a.csv", "b.csv")
    assert found.findings.of("units of files", "p")[0].detail == "a.csv says 'bar', b.csv 'psi'"


def test_files_need_clocks_of_one_kind_and_the_same_channels(tmp_path):
    put(tmp_path, "a.csv", 0.0), put(tmp_path, "b.csv", 5.0, stamp=True)
    with pytest.raises(InputError, match="clocks of different kinds"):
        joined(tmp_path, "a.csv", "b.csv")
    (tmp_path / "c.csv").write_text("time,q\n9.0,1\n9.1,2\n")
    with pytest.raises(InputError, match=r"c.csv: no channel 'p'"):
        joined(tmp_path, "a.csv", "c.csv")


def test_patterns_stand_for_files(tmp_path):
    a, b = put(tmp_path, "a.csv", 0.0), put(tmp_path, "b.csv", 5.0)
    assert expand([str(tmp_path / "?.csv")]) == [a, b]
    assert expand(a) == [a]
    with pytest.raises(InputError, match="no file matches"):
        expand(str(tmp_path / "*.txt"))


def test_a_range_suggested_from_one_file_is_loud_about_the_peaks_of_the_next(tmp_path):
    a = put(tmp_path, "a.csv", 0.0, n=50)
    b = put(tmp_path, "b.csv", 1.0)
    import tomllib

    ranges = [
        next(c["range"] for c in tomllib.loads(suggest_channels(files))["channel"] if c["source"] == "p")
        for files in (a, [a, b])
    ]
    assert ranges[0][1] < 109.0
    assert ranges[1][1] > 110.0
    narrow = MAP | {"channel": [MAP["channel"][0], MAP["channel"][1] | {"range": ranges[0]}]}
    found = import_log([a, b], channel_map(narrow), tmp_path / "t.parquet")
    assert found.findings.of("implausible", "p")[0].level == "error"
    assert "widen it" in found.findings.of("implausible", "p")[0].detail


def with_clock(values):
    """A log that says when it began: samples of some signals, every 10 ms."""
    signals = [Signal(key, "bar", 0) for key in values]

    def read(group, wanted, time, findings):
        n = len(next(iter(values.values())))
        yield LogBlock(np.arange(n) + 1, 0.01 * np.arange(n), {key: values[key] for key in wanted}, {}, 1.0)

    return Log(Path("log"), signals, True, read, began=1.7e9)


def both(first, second):
    """Whether two logs that began at the same time hold the same."""
    return _agree(*(_Part(with_clock(values), 1.7e9, 1.7e9 + 1.0, 101) for values in (first, second)))


SAW = np.arange(101) % 11 / 10.0  # its spread is 1


@pytest.mark.parametrize(("off", "same"), [(0.099, True), (-0.099, True), (0.101, False), (-0.101, False)])
def test_values_are_the_same_within_a_tenth_of_their_spread(off, same):
    assert both({"p": 50.0 * SAW}, {"p": 50.0 * (SAW + off)}) == same


@pytest.mark.parametrize(
    ("signals", "same"),
    [
        ("aao", True), ("ao", False), ("aaaaoooa", True), ("aaaaoooo", False), ("aaaaooooa", False), ("ss", True), ("sao", False),
        ("sssssssso", True),
    ],
)  # fmt: skip
def test_most_of_the_first_eight_signals_that_vary_say_whether_files_hold_the_same(signals, same):
    kinds = {"a": (SAW, SAW), "o": (SAW, SAW + 1.0), "s": (np.ones(101), np.zeros(101))}  # alike, other, still
    first, second = ({f"p{k}": kinds[kind][side] for k, kind in enumerate(signals)} for side in (0, 1))
    assert both(first, second) == same


@pytest.mark.parametrize(("begin", "anew"), [(0.07, True), (0.08, False)])
def test_clocks_begin_anew_within_a_twentieth_of_the_shorter_file(tmp_path, begin, anew):
    put(tmp_path, "a.csv", 0.0), put(tmp_path, "b.csv", begin, n=150)  # 1.49 s
    found, _ = joined(tmp_path, "a.csv", "b.csv")
    assert bool(found.findings.of("files begin anew")) == anew
    assert bool(found.findings.of("files overlap")) != anew


@pytest.mark.parametrize(("begin", "dated"), [(315_532_799.0, False), (315_532_801.0, True)])
def test_times_from_1980_on_are_dates_and_no_clocks_that_begin_anew(tmp_path, begin, dated):
    put(tmp_path, "a.csv", begin), put(tmp_path, "b.csv", begin, n=150)
    found, table = joined(tmp_path, "a.csv", "b.csv")
    assert bool(found.findings.of("files overlap")) == dated
    assert len(table) == (200 if dated else 350)
