"""The quality report names each fault that is seeded in a log, with its rows, and none in a healthy one."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io

from helpers.group_log_kinds import cases as group_cases
from helpers.log_kinds import cases
from helpers.logs_made import MAP, RASTER, UNITS, healthy, imported, lose, put, write_csv
from polydraulic.errors import InputError
from polydraulic.measure import import_log, load_channels, write_quality
from polydraulic.measure.channels import channel_map
from polydraulic.measure.columns_made import RateChannel
from polydraulic.measure.findings import KINDS, Findings
from polydraulic.measure.importing import _check_windows, _copies
from polydraulic.tables import read_table


@pytest.mark.parametrize("seed", range(8))
def test_a_healthy_log_raises_nothing(tmp_path, seed):
    found = imported(tmp_path, healthy(seed))
    assert [str(f) for f in found.findings] == []
    assert (found.n_row, found.n_segment) == (3999, 1)  # the last row has no speed, nor one after it


def overlap(columns):
    again = slice(1900, 2000)
    return {name: np.concatenate([v[:2000], v[again], v[2000:]]) for name, v in columns.items()}


def clock_back(columns):
    return put(columns, "time", 2000, columns["time"][1900])


def clock_ahead(columns):
    return put(columns, "time", 2000, columns["time"][2000] + 500.0)


def frozen(columns):
    return put(columns, "p_head", slice(1000, 1300), columns["p_head"][999])


def to_zero(columns):
    return put(columns, "lever", slice(*busy(columns)), 0.0)


def busy(columns):
    """Rows at which the lever is far out, for a second at least."""
    out = np.flatnonzero(np.abs(columns["lever"]) > 0.5)
    return int(out[0]), int(out[0]) + 60


def uneven(columns):
    shift = np.random.default_rng(1).uniform(-0.45, 0.45, len(columns["time"])) * RASTER
    return {**columns, "time": columns["time"] + shift}


# fault -> (columns, kind, channel, rows it must be found in or None)
FAULTS = {
    "half a second is missing": (lambda c: lose(c, slice(1000, 1050)), "gap", "time", [(1001, 1001)]),
    "a second is there twice": (overlap, "overlap", "time", [(2001, 2099)]),
    "the clock steps back once": (clock_back, "clock jump", "time", [(2001, 2001)]),
    "the clock steps ahead once": (clock_ahead, "clock jump", "time", [(2001, 2001)]),
    "a time comes twice": (lambda c: put(c, "time", 100, c["time"][99]), "time repeats", "time", [(101, 101)]),
    "a time is empty": (lambda c: put(c, "time", 100, np.nan), "no time", "time", [(101, 101)]),
    "time is in ms": (lambda c: {**c, "time": 1e3 * c["time"]}, "raster", "time", None),
    "every other row is missing": (lambda c: lose(c, slice(1, None, 2)), "raster", "time", None),
    "intervals jitter": (uneven, "irregular", "time", None),
    "a value is a word": (lambda c: put(c, "lever", [50, 51], "ERR"), "text", "lever", [(51, 52)]),
    "a value is infinite": (lambda c: put(c, "p_head", 70, np.inf), "infinite", "p_head", [(71, 71)]),
    "a channel is empty": (lambda c: put(c, "speed", slice(None), np.nan), "empty", "speed", None),
    "a channel is dead": (lambda c: put(c, "p_head", slice(None), 81.5), "constant", "p_head", None),
    "a channel drops out": (lambda c: put(c, "lever", slice(500, 600), np.nan), "dropout", "lever", [(601, 601)]),
    "a few values are implausible": (
        lambda c: put(c, "p_head", [10, 20, 21], 999.0), "implausible", "p_head", [(11, 11), (21, 22)],
    ),
    "pressure is in psi": (lambda c: {**c, "p_head": 14.5038 * c["p_head"]}, "unit by values", "p_head", None),
    "pressure is turned round": (lambda c: {**c, "p_head": -c["p_head"]}, "sign", "p_head", None),
    "single spikes": (lambda c: put(c, "p_head", [1500, 2500], 240.0), "spike", "p_head", [(1501, 1501), (2501, 2501)]),
    "a spike within the range": (lambda c: put(c, "p_head", 1500, 165.0), "spike", "p_head", [(1501, 1501)]),
    "no value has a number": (lambda c: put(c, "lever", [60, 61, 62], -999.0), "sentinel", "lever", [(61, 63)]),
    "a sensor is stuck": (frozen, "frozen", "p_head", [(1000, 1300)]),
    "a signal is lost to 0": (to_zero, "frozen", "lever", None),
    "a sensor is at its end": (lambda c: {**c, "p_head": np.minimum(c["p_head"], 105.0)}, "clipped", "p_head", None),
    "digits are too coarse": (lambda c: {**c, "p_head": 15.0 * np.round(c["p_head"] / 15.0)}, "coarse", "p_head", None),
    "two channels are one": (lambda c: {**c, "lever": c["p_head"] / 1.0}, "copy", "p_head", None),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_seeded_fault_is_named_with_its_rows(tmp_path, fault):
    change, kind, channel, rows = FAULTS[fault]
    found = imported(tmp_path, change(healthy()), MAP.replace("[-1.2, 1.2]", "[-1000, 1000]"))
    named = found.findings.of(kind, channel)
    assert named, [str(f) for f in found.findings]
    if rows is not None:
        assert named[0].rows == rows


# faults of the file rather than of its numbers
def test_broken_lines_are_named(tmp_path):
    def cut(text):
        lines = text.splitlines()
        lines[10], lines[30] = lines[10] + ",7", "0.3"
        return "\n".join(lines)

    found = imported(tmp_path, healthy(), change=cut)
    assert [(f.kind, f.rows) for f in found.findings] == [("missing line", [(10, 10), (30, 30)])]


def test_row_numbers_count_broken_lines(tmp_path):
    found = imported(
        tmp_path, put(healthy(), "p_head", 100, 999.0), change=lambda text: text.replace("\n0.3,", "\n0.3,,,,,", 1)
    )
    assert found.findings.of("implausible")[0].rows == [(101, 101)]


def test_a_name_that_comes_twice_is_named(tmp_path):
    columns = healthy()
    found = imported(
        tmp_path, {**columns, "again": columns["lever"] + 1.0}, names=["time", "lever", "p_head", "speed", "lever"]
    )
    assert [(f.kind, f.channel) for f in found.findings] == [("duplicate", "lever")]
    assert np.max(np.abs(found.excerpt["lever"])) < 1.2  # the first was taken


@pytest.mark.parametrize(
    ("unit", "kinds"),
    [
        ("psi", ["unit"]),
        ("l/min", ["unit"]),
        ("furlong??", ["unit"]),
        ("bar(a)", ["unit"]),
        ("barg", []),
        ("bar(g)", []),
        ("", []),
    ],
)
def test_a_unit_other_than_the_logs_is_named(tmp_path, unit, kinds):
    found = imported(tmp_path, healthy(), units={**UNITS, "p_head": unit})
    assert [f.kind for f in found.findings] == kinds
    assert all("the map 'bar'" in f.detail for f in found.findings)


@pytest.mark.parametrize(
    ("unit", "measured"), [("kN", "force"), ("degC", "temperature"), ("", "number"), ("l/min", "flow")]
)
def test_a_pressure_of_the_log_becomes_nothing_else(tmp_path, unit, measured):
    named = MAP.replace('"p_head"\nname = "boom.p_a"', '"head"').replace('"bar"', f'"{unit}"')
    columns = {"head" if name == "p_head" else name: values for name, values in healthy().items()}
    with pytest.raises(
        InputError,
        match=f"channel 'head' is a pressure in 'bar\\(g\\)', but the map's unit '{unit}' measures {measured}",
    ):
        imported(tmp_path, columns, named, units={**UNITS, "head": "bar(g)"})
    said = imported(
        tmp_path,
        columns,
        named.replace(f'"{unit}"', f'"{unit}"\nkind = "{measured}"'),
        units={**UNITS, "head": "bar(g)"},
    )
    assert [f.kind for f in said.findings] == ["unit"]


# unit -> (Pa of one, whether it is absolute)
PRESSURES = {
    "bar": (1e5, False), "bar(g)": (1e5, False), "bar g": (1e5, False), "barg": (1e5, False), "bar rel": (1e5, False), "kgf/cm2": (98066.5, False),
    "kg/cm2": (98066.5, False), "psig": (6894.757293168, False), "kPa g": (1e3, False), "bar(a)": (1e5, True), "bara": (1e5, True), "barA": (1e5, True),
    "bar abs": (1e5, True), "psi(a)": (6894.757293168, True), "psia": (6894.757293168, True), "kPa(a)": (1e3, True), "mbar(a)": (100.0, True),
    "MPa(abs)": (1e6, True), "ata": (98066.5, True),
}  # fmt: skip


@pytest.mark.parametrize("unit", PRESSURES)
def test_gauge_and_absolute_pressures_of_logs(tmp_path, unit):
    factor, absolute = PRESSURES[unit]
    log = healthy(n=500)
    columns = {**log, "p_head": log["p_head"] * 1e5 / factor}
    free = re.sub(r"range = \[.*\]\n", "", MAP).replace('"bar"', f'"{unit}"')
    for stated, atmosphere in (("", 101325.0), ('atmosphere = "0.95 bar"\n', 95000.0)):
        found = imported(tmp_path, columns, stated + free, units={**UNITS, "p_head": unit})
        named = [f for f in found.findings if f.channel == "p_head"]
        assert [f.kind for f in named] == (["atmosphere"] if absolute and not stated else [])
        assert all("1.01325 bar were subtracted from" in str(f) for f in named)
        gauge = found.excerpt["boom.p_a"]
        assert gauge == pytest.approx(log["p_head"][:-1] * 1e5 - (atmosphere if absolute else 0.0), rel=1e-9)
        back = found.channels.conversion(found.channels.used[1])
        assert back.from_si(gauge) == pytest.approx(columns["p_head"][:-1], rel=1e-9)


@pytest.mark.parametrize(("unit", "stated", "taken", "why"), [
    ("bar", "", None, ""),
    ("bar(a)", "", 101325.0, "1.01325 bar were subtracted from absolute ones (the standard atmosphere)"),
    ("bar(a)", 'atmosphere = "0.95 bar"\n', 95000.0, "0.95 bar were subtracted from absolute ones (as the map says)"),
])  # fmt: skip
def test_the_report_names_the_atmosphere(tmp_path, unit, stated, taken, why):
    found = imported(
        tmp_path, healthy(n=500), stated + MAP.replace('"bar"', f'"{unit}"'), units={**UNITS, "p_head": unit}
    )
    write_quality(found, tmp_path / "quality.html")
    assert json.loads((tmp_path / "quality.json").read_text())["atmosphere_Pa"] == taken
    page = (tmp_path / "quality.html").read_text()
    assert why in page
    assert ("were subtracted from absolute ones" in page) == (taken is not None)


def test_a_log_that_gives_no_row_is_named_and_no_table_is_written(tmp_path):
    columns = healthy()
    columns["p_head"][::1] = np.where(np.arange(4000) < 2000, columns["p_head"], np.nan)
    columns["speed"] = np.where(np.arange(4000) < 2000, np.nan, columns["speed"])
    found = imported(tmp_path, columns)
    assert found.findings.of("no rows")
    assert not (tmp_path / "table.parquet").exists()


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1.0), ("s", 1000.0), ("s", 1.0 / 86400.0)])
def test_a_wrong_unit_of_time_is_named_where_the_map_has_no_raster_for_the_time(tmp_path, unit, factor):
    columns = healthy(n=200)
    columns["time"] = factor * columns["time"]
    plain = MAP.replace('unit = "s"\nraster = "10 ms"', f'unit = "{unit}"')
    found = imported(tmp_path, columns, plain, units={**UNITS, "time": ""})
    named = found.findings.of("raster", "time")
    assert ["check the unit of time" in finding.detail for finding in named] == [True]


def test_a_table_of_thousands_of_rows_between_two_samples_is_refused(tmp_path):
    columns = healthy(n=200)
    columns["time"] = 1e6 * columns["time"]  # us
    plain = MAP.replace('unit = "s"\nraster = "10 ms"', 'unit = "s"')
    with pytest.raises(
        InputError,
        match=r"raster = 0\.01 s: samples come every 1e\+04 s, and the table would have 1000000 rows .* unit of time",
    ):
        imported(tmp_path, columns, plain, units={**UNITS, "time": ""})
    assert not (tmp_path / "table.parquet").exists()


def test_a_log_is_not_replaced_by_its_table(tmp_path, monkeypatch):
    log = tmp_path / "log.csv"
    log.write_text("time,p\n" + "".join(f"{0.01 * k:.2f},{k % 7}\n" for k in range(50)))
    before = log.read_bytes()
    time, p = {"source": "time", "role": "time"}, {"source": "p", "role": "input", "unit": "bar"}
    channels = channel_map({"raster": "10 ms", "channel": [time, p]})
    monkeypatch.chdir(tmp_path)
    for given in (log, [log], "*.csv"):
        with pytest.raises(InputError, match=r"log\.csv: is the file that is read"):
            import_log(given, channels, "log.csv")
    assert log.read_bytes() == before
    assert import_log(log, channels, "table.csv").n_row == 50
    assert import_log(log, channels, "table.csv").n_row == 50  # an older table is replaced


def test_every_kind_of_finding_is_seeded():
    elsewhere = {"missing line", "duplicate", "unit", "atmosphere", "no rows", "turns"}
    elsewhere |= {
        kind for *_, came in (*cases(), *group_cases()) if not isinstance(came, str) for kind in came
    }  # files of a log reader
    elsewhere |= {"files begin anew", "files overlap", "file repeats", "units of files"}  # formats/test_campaign.py
    assert {kind for _, kind, _, _ in FAULTS.values()} | elsewhere == set(KINDS)


def test_a_held_channel_that_is_written_only_when_it_changes_is_no_fault(tmp_path):
    columns = healthy()
    level = np.repeat(np.arange(100.0) % 7, 40)
    columns["lever"] = np.where(np.arange(4000) % 40 == 0, level, np.nan)
    changed = MAP.replace('unit = "V"\nrange = [-1.2, 1.2]', 'between = "hold"\nraster = "1 s"')
    found = imported(tmp_path, columns, changed, units={**UNITS, "lever": ""})
    assert [str(f) for f in found.findings] == []
    assert np.array_equal(found.excerpt["lever"], level[:3999])


@pytest.mark.parametrize("between", ["linear", "hold"])
def test_an_angle_goes_on_past_a_full_turn(tmp_path, between):
    time = 0.01 * np.arange(3000)
    angle = 400.0 * np.sin(0.4 * time)
    lines = "".join(f"{t:.2f},{a:.2f}\n" for t, a in zip(time, np.mod(angle, 360.0), strict=True))
    (tmp_path / "log.csv").write_text("time,swing\n" + lines)
    swing = {"source": "swing", "role": "input", "unit": "deg", "range": [0, 360], "between": between}
    channels = channel_map({"raster": "10 ms", "channel": [{"source": "time", "role": "time"}, swing]})
    found = import_log(tmp_path / "log.csv", channels, tmp_path / "table.parquet")
    (turns,) = found.findings
    anew = np.flatnonzero(np.abs(np.diff(np.mod(np.round(angle, 2), 360.0))) > 180.0) + 2
    assert (turns.kind, turns.channel, turns.rows) == ("turns", "swing", [(row, row) for row in anew.tolist()])
    table = read_table(tmp_path / "table.parquet")
    assert np.allclose(np.degrees(table["swing"]), angle[: len(table)], atol=0.01)


@pytest.mark.parametrize(("n", "named"), [(9, []), (10, ["q"])])
def test_ten_numbers_alike_are_a_copy(n, named):
    def channel(source, crc, given, low=0.0):
        return SimpleNamespace(channel=SimpleNamespace(source=source), crc=crc, given=given, low=low, high=5.0)

    findings = Findings()
    of = [channel("p", 7, n), channel("q", 7, n), channel("r", 8, n), channel("s", 7, n + 1)]
    _copies([*of, channel("still", 9, n, 5.0), channel("still too", 9, n, 5.0)], findings)
    assert [(f.kind, f.channel, f.detail) for f in findings] == [("copy", name, "of 'p'") for name in named]


@pytest.mark.parametrize(("window", "allowed"), [(0.3, True), (0.2999, False)])
def test_a_rate_is_made_of_three_samples(window, allowed):
    channels = SimpleNamespace(rates=[RateChannel("v", "x", window)])
    checks = [SimpleNamespace(channel=SimpleNamespace(name="x"), raster=0.1)]
    if allowed:
        _check_windows(channels, checks)
    else:
        with pytest.raises(InputError, match="= 0.2999 s: 'x' has a sample every 0.1 s only; 0.3 s at least"):
            _check_windows(channels, checks)


def silent_at_times():
    """A log whose pressure is silent for a second and begins late, and whose lever ends early."""
    columns = healthy()
    columns["p_head"][:50] = columns["p_head"][1000:1100] = np.nan
    columns["lever"][3900:] = np.nan
    return columns


@pytest.mark.parametrize("kind", ["csv", "mat", "parquet"])
@pytest.mark.parametrize("ending", ["parquet", "csv"])
def test_rows_in_which_some_channels_are_silent_are_kept_if_asked_for(tmp_path, kind, ending):
    from polydraulic.tables import read_table

    columns, log = silent_at_times(), tmp_path / f"log.{kind}"
    if kind == "csv":
        write_csv(log, columns)
    elif kind == "mat":
        scipy.io.savemat(log, columns)
    else:
        pq.write_table(pa.table({n: pa.array(v, from_pandas=True) for n, v in columns.items()}), log)
    (tmp_path / "map.toml").write_text(MAP)
    table, whole = tmp_path / f"table.{ending}", tmp_path / f"whole.{ending}"
    found = import_log(log, load_channels(tmp_path / "map.toml"), table, partial=True)
    assert (found.n_row, found.n_segment) == (4000, 1)
    assert found.missing == {"lever": 100, "boom.p_a": 150, "speed": 1}
    every = read_table(table, partial=True)
    assert np.flatnonzero(~every.known(["boom.p_a"])).tolist() == [*range(50), *range(1000, 1100)]
    assert every.columns["boom.p_a"][60] == pytest.approx(1e5 * columns["p_head"][60])
    import_log(log, load_channels(tmp_path / "map.toml"), whole)
    assert read_table(table) == read_table(whole)  # who asks for all channels gets the rows of an import without it
    assert len(read_table(table, ["time", "lever"])) == 3900
    assert len(found.excerpt) == len(read_table(whole))
    assert len(np.unique(found.excerpt["segment"])) == 2
    write_quality(found, tmp_path / "q.html")
    assert (
        "it is partial, rows without a value of a channel: lever 100, boom.p_a 150" in (tmp_path / "q.html").read_text()
    )
    assert json.loads((tmp_path / "q.json").read_text())["rows_missing"]["boom.p_a"] == 150


@pytest.mark.parametrize(("begins", "rows"), [(0.5, 50), (0.99, 1), (1.0, 0), (1000.0, 0)])
def test_channels_whose_times_do_not_meet_are_named(tmp_path, begins, rows):
    from asammdf import MDF, Signal

    time = 0.01 * np.arange(100)
    with MDF(version="4.10") as file:
        for name, at in (("p", 0.0), ("q", begins)):
            file.append([Signal(5.0 + np.sin(time), time + at, "bar", name)])
        file.save(tmp_path / "log.mf4")
    channels = [{"source": name, "role": "input", "unit": "bar"} for name in ("p", "q")]
    given = channel_map({"raster": "10 ms", "channel": channels})
    found = import_log(tmp_path / "log.mf4", given, tmp_path / "t.parquet")
    assert found.n_row == rows
    said = [f.detail for f in found.findings.of("no rows")]
    words = f"'q' begins at {begins:g} s, when 'p' has ended at 0.99 s: look at their clocks, or import them apart"
    assert said == ([] if rows else [words])
