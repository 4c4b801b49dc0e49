"""What text and Parquet files may look like: each kind is read, named or refused, as the documentation says."""

import re

import numpy as np
import pytest

from helpers.log_kinds import PRESSURE, READ, REFUSED, TIME, cases, clocked, lines, write
from polydraulic.columns.rows import without_cut_line
from polydraulic.errors import InputError
from polydraulic.measure import import_log, load_channels, open_log, suggest_channels
from polydraulic.measure.channels import channel_map
from polydraulic.measure.findings import Findings
from polydraulic.tables import read_table

ABOUT_VALUES = {"constant", "copy", "coarse", "clipped", "frozen", "spike", "dropout", "gap", "irregular"}
CASES = [pytest.param(*case, id=f"{case[0]}: {case[1]}") for case in cases()]


def import_of(log, unit="s", raster="10 ms", dates=None, out="table.parquet", p_unit="bar"):
    time = {"source": "time", "role": "time", "unit": unit} | ({"dates": dates} if dates else {})
    channels = [time, {"source": "p", "role": "input", "unit": p_unit}]
    found = import_log(log, channel_map({"raster": raster, "channel": channels}), log.parent / out)
    return found, read_table(log.parent / out) if found.n_row else None


@pytest.mark.parametrize(("group", "what", "content", "came"), CASES)
def test_what_comes_of_a_file(tmp_path, group, what, content, came):
    log = write(tmp_path, what, content)
    unit = "ns" if "since 1970" in what else "ms" if "whole numbers" in what else "s"
    if came == REFUSED:
        with pytest.raises(InputError, match=log.name):
            import_of(log, unit)
        return
    found, table = import_of(log, unit, "1 ms" if unit == "ms" else "10 ms")
    kinds = {f.kind for f in found.findings} - ABOUT_VALUES
    assert kinds == (set() if came == READ else set(came))
    assert found.n_row >= 58
    assert np.diff(table["time"]) == pytest.approx(np.full(found.n_row - 1, 0.001 if unit == "ms" else 0.01), abs=1e-6)
    if came == READ:
        assert np.interp(TIME[:59], table["time"] - table["time"][0], table["p"]) == pytest.approx(
            1e5 * PRESSURE[:59], rel=2e-3
        )


@pytest.mark.parametrize("given", [case[2] for case in cases() if case[3] == READ and isinstance(case[2], str)][:20])
def test_a_suggested_map_is_one_that_imports(tmp_path, given):
    log = write(tmp_path, "text", given)
    (tmp_path / "map.toml").write_text(suggest_channels(log))
    assert 'role = "time"' in (tmp_path / "map.toml").read_text()
    assert import_log(log, load_channels(tmp_path / "map.toml"), tmp_path / "t.parquet").n_row >= 58


def wide(names, rows):
    return (
        "\n".join([",".join(names), *(",".join([f"{n / 100:.2f}", *["0.5"] * (len(names) - 1)]) for n in range(rows))])
        + "\n"
    )


def test_a_file_whose_header_is_too_long_is_not_said_to_have_no_rows(tmp_path):
    names = ["time", *(f"channel_{n}_{'x' * 99}" for n in range(40_000))]
    (tmp_path / "log.csv").write_text(wide(names, 1))
    with pytest.raises(InputError, match=r"log\.csv: the names .* first 4194304 bytes.*Parquet"):
        open_log(tmp_path / "log.csv")


@pytest.mark.parametrize("rows", [1, 2, 60])
def test_thousands_of_columns_are_read(tmp_path, rows):
    names = ["time", *(f"channel_{n}" for n in range(8000)), "p"]
    (tmp_path / "log.csv").write_text(wide(names, rows))
    _, table = import_of(tmp_path / "log.csv")
    assert len(table) == rows
    assert set(table["p"]) == {0.5e5}


def test_names_and_units_go_over_lines_in_quotes_alone(tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes(b'time,"Pressure,\r\nboom\r\n(bar)","pipe 5"" wide"\r\n0.00,1,2\r\n0.01,3,4\r\n')
    with open_log(log) as found:
        assert [(s.name, s.unit) for s in found.signals] == [
            ("time", ""),
            ("Pressure, boom", "bar"),
            ('pipe 5" wide', ""),
        ]
    log.write_text('a "quoted word, \n"Time,p\n0.00,1\n0.01,2\n0.02,3\n0.03,4\n0.04,5\n0.05,6\n')
    with open_log(log) as found:
        assert len(found.signals) == 2


def test_the_unit_of_the_first_column_may_stand_alone(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time,p\nms,\n" + "".join(f"{10 * k},{k % 7}\n" for k in range(50)))
    assert 'role = "time"\nunit = "ms"' in suggest_channels(log)


@pytest.mark.parametrize(
    ("names", "units"), [("U1,I1", "V,A"), ("F1,F2,I4", "kN,bar,A"), ("real,single,double", "V,A,bar")]
)
def test_names_that_look_like_kinds_of_data_are_names(tmp_path, names, units):
    log = tmp_path / "log.csv"
    rows = "".join(",".join([f"{k}.5"] * (names.count(",") + 1)) + "\n" for k in range(9))
    log.write_text(f"{names}\n{units}\n{rows}")
    with open_log(log) as found:
        assert [(s.name, s.unit) for s in found.signals] == list(zip(names.split(","), units.split(","), strict=True))


def test_a_first_line_of_kinds_of_data_that_repeat_gives_no_names(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("f8,f8,i4\nt,p,n\n" + "".join(f"{k}.5,{k},3\n" for k in range(9)))
    with open_log(log) as found:
        assert [(s.name, s.unit) for s in found.signals] == [("t", ""), ("p", ""), ("n", "")]


@pytest.mark.parametrize("cell", ["n/a", "--", "NaN", "-"])
def test_a_first_row_that_lacks_its_first_value_is_a_row(tmp_path, cell):
    log = tmp_path / "log.csv"
    log.write_text(f"{cell},5,6\n0,0,0\n1,1,1\n")
    with open_log(log) as found:
        assert [s.name for s in found.signals] == ["column 1", "column 2", "column 3"]
        (block,) = found.read(0, ["column 2"], None, Findings())
    assert block.values["column 2"].tolist() == [5.0, 0.0, 1.0]


@pytest.mark.parametrize(("zeros", "kind"), [(b"\0" * 512 + b"\n", "missing line"), (b"\0" * 512, "no time")])
def test_zeros_between_rows_are_told_wherever_they_stand(tmp_path, zeros, kind):
    rows = [b"%d,%d\n" % (k, k % 7) for k in range(9000)]
    told = []
    for place in (1, 30, 8990):  # the last one behind the bytes that the header is looked for in
        (tmp_path / "log.csv").write_bytes(b"time,p\n" + b"".join([*rows[:place], zeros, *rows[place:]]))
        found, table = import_of(tmp_path / "log.csv", raster="1 s")
        assert table["time"][-1] == 8999.0
        told.append([(f.kind, f.count) for f in found.findings if f.kind in ("missing line", "no time", "text")])
    assert told == [[(kind, 1)]] * 3


@pytest.mark.parametrize(
    "content",
    [
        b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\1\0\n1,2\n3,4\n",
        b"time,p\n" + np.array([0, 1, 1, 0] * 20, "f4").tobytes() + b"\n1,2\n3,4\n",
        b"time,p\n" + np.arange(40, dtype="i2").tobytes() + b"\n1,2\n3,4\n",
    ],
)
def test_zeros_of_a_binary_file_behind_a_first_line_of_text_are_refused(tmp_path, content):
    (tmp_path / "log.csv").write_bytes(content)
    with pytest.raises(InputError, match="is not text"):
        open_log(tmp_path / "log.csv")


def test_names_that_come_again_are_parted_by_the_line_above_them(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(
        "Clock,Stick,Boom,,\ntime,p,x,q,p\ns,bar,m,l/min,bar\n" + "".join(f"{k},1,2,3,{k}\n" for k in range(9))
    )
    with open_log(log) as found:
        assert [(s.name, s.unit) for s in found.signals] == [
            ("time", "s"), ("Stick/p", "bar"), ("x", "m"), ("q", "l/min"), ("Boom/p", "bar")
        ]  # fmt: skip
        assert not found.duplicates


def test_a_whole_column_is_read_in_one_way(tmp_path):
    (tmp_path / "log.csv").write_text("time;p\n" + "".join(f"{i};{'999,5' if i % 2 else '1.002'}\n" for i in range(60)))
    found, table = import_of(tmp_path / "log.csv", "ms", "1 ms", p_unit="kPa")
    assert (table["p"].min(), table["p"].max()) == pytest.approx((999.5e3, 1002e3))
    assert "such as '1.002'" in found.findings.of("thousands")[0].detail


@pytest.mark.parametrize("n", [300, 300_000])
def test_thousands_that_come_late_hold_for_all_rows(tmp_path, n):
    cells = [f"{900 + i % 90}" if i < n - 50 else f"1.{i % 90:03d},5" for i in range(n)]
    (tmp_path / "log.csv").write_text("time;p\n" + "".join(f"{i};{cell}\n" for i, cell in enumerate(cells)))
    with open_log(tmp_path / "log.csv") as log:
        findings = Findings()
        values = np.concatenate([b.values["p"] for b in log.read(0, ["p"], "time", findings)])
    assert values[0] == 900.0
    assert values[-50:] == pytest.approx(1000.5 + np.arange(n - 50, n) % 90)
    assert [f.kind for f in findings] == ["thousands"]


def test_dates_are_never_guessed(tmp_path):
    (tmp_path / "log.csv").write_text(clocked("03/04/2024 {}", 40000.0))
    with pytest.raises(InputError, match=re.escape("'03/04/2024 11:06:40.000' can be read in two ways")):
        import_of(tmp_path / "log.csv")
    for order, day in (("dd/mm/yyyy", "2024-04-03"), ("mm/dd/yyyy", "2024-03-04")):
        _, table = import_of(tmp_path / "log.csv", dates=order)
        assert table["time"][0] == pytest.approx(np.datetime64(day).astype("datetime64[s]").astype(float) + 40000.0)
    suggested = suggest_channels(tmp_path / "log.csv")
    assert '# dates = "dd/mm/yyyy"' in suggested
    (tmp_path / "map.toml").write_text(suggested)
    with pytest.raises(InputError, match="can be read in two ways"):
        import_log(tmp_path / "log.csv", load_channels(tmp_path / "map.toml"), tmp_path / "t.csv")


def test_a_late_day_tells_the_order_of_all_dates(tmp_path):
    rows = [f"{day:02d}/04/2024 10:00:00,{day}\n" for day in range(1, 20)]
    (tmp_path / "log.csv").write_text("time,p\n" + "".join(rows * 1))
    found, table = import_of(tmp_path / "log.csv", raster="1 h")
    assert table["time"][0] == pytest.approx(np.datetime64("2024-04-01T10").astype("datetime64[s]").astype(float))
    assert table["time"][-1] - table["time"][0] == pytest.approx(18 * 86400.0)
    assert "no time" not in {f.kind for f in found.findings}


def test_a_time_that_cannot_be_read_says_nothing_about_the_channels(tmp_path):
    (tmp_path / "log.csv").write_text(lines("at {t:.2f},{p}\n"))
    found, _ = import_of(tmp_path / "log.csv")
    assert [f.kind for f in found.findings] == ["no time", "no rows"]
    assert "such as 'at 0.00'" in found.findings.of("no time")[0].detail


def test_the_headers_own_text_names_a_channel_too(tmp_path):
    (tmp_path / "log.csv").write_text(
        lines("{t:.2f},{p}\n", "Time (s),p (bar),p (A),p (B)\n").replace("\n", ",1,2\n").replace("(B),1,2", "(B)")
    )
    with open_log(tmp_path / "log.csv") as log:
        assert [(s.name, s.unit) for s in log.signals] == [("Time", "s"), ("p", "bar"), ("p (A)", ""), ("p (B)", "")]
        assert log.signal("p (bar)") == log.signal("p")
        (block,) = log.read(0, ["p (bar)"], "Time (s)", Findings())
    assert np.array_equal(block.values["p (bar)"], PRESSURE)


def test_ragged_rows_stay_in_their_order_across_blocks(tmp_path):
    n = 400_000
    text = "time,p,x\n" + "".join(f"{i},{i % 100}.5" + (",1\n" if i % 3 else "\n") for i in range(n))
    (tmp_path / "log.csv").write_text(text)
    with open_log(tmp_path / "log.csv") as log:
        findings = Findings()
        blocks = list(log.read(0, ["p", "x"], "time", findings))
    assert len(blocks) > 1
    assert np.array_equal(np.concatenate([b.rows for b in blocks]), np.arange(n) + 1)
    assert np.array_equal(np.concatenate([b.time for b in blocks]), np.arange(n))
    assert np.array_equal(np.isnan(np.concatenate([b.values["x"] for b in blocks])), np.arange(n) % 3 == 0)
    assert findings.of("short line")[0].count == -(-n // 3)


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        ("1\u00a0{i:03d},5", 1000.5),
        ("1\u202f{i:03d},5", 1000.5),
        ("1 {i:03d},5", 1000.5),
        ("1'{i:03d},5", 1000.5),
        ("\u22121{i:03d},5", None),
    ],
)
def test_marks_that_can_only_be_thousands_and_minus_signs_of_typography_are_read(tmp_path, cell, expected):
    rows = "".join(f"0,{i:02d};{cell.format(i=i)}\n" for i in range(60))
    (tmp_path / "log.csv").write_text("time;p\n" + rows, encoding="utf-8")
    _, table = import_of(tmp_path / "log.csv")
    number = np.arange(60.0)
    assert table["p"] == pytest.approx(1e5 * (-1000.5 - number if expected is None else expected + number))


def test_a_column_with_the_other_mark_before_three_digits_is_not_made_a_thousand_times_as_large(tmp_path):
    german = "".join(f"0,{i:02d};{'109.25' if i == 50 else f'1{i:02d},125'}\n" for i in range(60))
    (tmp_path / "log.csv").write_text("time;p\n" + german)
    found, table = import_of(tmp_path / "log.csv")
    assert table["p"].max() == pytest.approx(159.125e5)
    assert "as in other columns" in found.findings.of("decimal mark")[0].detail
    (tmp_path / "log.csv").write_text("time;p\n" + "".join(f"0.{i:02d};1,{i:03d}\n" for i in range(60)))
    found, table = import_of(tmp_path / "log.csv")
    assert table["p"] == pytest.approx(1e5 * (1000.0 + np.arange(60)))
    assert "other columns have the decimal mark '.'" in found.findings.of("thousands")[0].detail


def test_a_header_that_comes_again_or_a_cell_of_two_lines_hides_no_rows(tmp_path):
    rows = [f"{i / 100:.2f},{100 + i},x" for i in range(190)]
    for amid in ("time,p,note", '0.95,100,"a\nb"'):
        text = "\n".join(["time,p,note", *rows[:100], amid, *rows[100:]])
        (tmp_path / "log.csv").write_text(text + "\n")
        with open_log(tmp_path / "log.csv") as log:
            assert [signal.name for signal in log.signals] == ["time", "p", "note"]
        found, _ = import_of(tmp_path / "log.csv")
        assert found.checks[0].given >= 190


def test_numbers_and_texts_of_one_column_are_the_same_in_blocks_of_any_size(tmp_path, monkeypatch):
    cells = [f"{100 + i / 8}" for i in range(4000)]
    cells[1500], cells[1501], cells[2500], cells[3500] = "error", " 7 ", "+8", "inf"
    rows = [f"{i / 100:.2f},{cell}" for i, cell in enumerate(cells)]
    rows[700], rows[3000], rows[3001] = "7.00,187.5,", "30.00", "# stop"
    (tmp_path / "log.csv").write_text("time,p\n" + "\n".join(rows))
    found = []
    for size in (997, 5000, 4 << 20):
        monkeypatch.setattr("polydraulic.columns.rows.BLOCK", size)
        findings = Findings()
        with open_log(tmp_path / "log.csv") as log:
            blocks = list(log.read(0, ["p"], "time", findings))
        places = [block.rows[block.text["p"]] for block in blocks]
        columns = [np.concatenate([getattr(block, key) for block in blocks]) for key in ("rows", "time")]
        values = np.concatenate([block.values["p"] for block in blocks])
        found.append(
            (
                [c.tolist() for c in columns],
                values.tolist(),
                np.concatenate(places).tolist(),
                [str(f) for f in findings],
            )
        )
    assert str(found[0]) == str(found[1]) == str(found[2])
    (rows, _), values, texts, said = found[0]
    assert (len(rows), texts) == (3998, [1501])
    assert (values[1501], values[2500]) == (7.0, 8.0)
    assert {text.partition(" ")[0] for text in said} == {"missing", "comment"}


def test_a_line_longer_than_a_block_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("polydraulic.columns.rows.BLOCK", 1000)
    (tmp_path / "log.csv").write_text("time,p\n" + "".join(f"{i},1\n" for i in range(300)) + "1," + "9" * 3000 + "\n")
    with pytest.raises(InputError, match="a line is longer than 1000 bytes"), open_log(tmp_path / "log.csv") as log:
        list(log.read(0, ["p"], "time", Findings()))


@pytest.mark.parametrize(
    ("end", "left_out"),
    [
        ("0.60,10", "10"),
        ("0.60,100.5", ""),
        ("0.60,10\n", ""),
        ("0.60,", ""),
        ("0.6", ""),
    ],
)
@pytest.mark.parametrize("size", [1 << 22, 600, 660])  # the last block is all, some lines, one
def test_a_last_value_that_may_be_cut_off_is_left_out(tmp_path, end, left_out, size, monkeypatch):
    monkeypatch.setattr("polydraulic.columns.rows.BLOCK", size)
    rows = "".join(f"{i / 100:.2f},{100 + i % 7}.5\n" for i in range(60))
    (tmp_path / "log.csv").write_text("time,p\n" + rows + end)
    found, table = import_of(tmp_path / "log.csv")
    cut = found.findings.of("cut line")
    assert [f.detail for f in cut] == (
        [f"its last value is {left_out!r}: if it is whole, end its line"] if left_out else []
    )
    assert [f.rows for f in cut] == ([[(61, 61)]] if left_out else [])
    assert (table["p"].min() == 10e5) == (end == "0.60,10\n")


@pytest.mark.parametrize(
    ("before", "last", "cut"),
    [
        (["10.01", "10.00"], "9.99", False),
        (["-0.10", "-0.05"], "0.00", False),
        (["10.01", "10.00"], "10.0", True),
        (["10.01", "10.00"], "10", True),
        (["1.00000e+02"], "1.00000e+0", True),
        (["0.25", "0.5", "", "1"], "1", False),  # no decimals were there before
        (["1012", "1013"], "10", True),
        (["12", "13"], "10", False),
        (["OVER", "NORMAL"], "OK", False),
        (['"10.01"'], '"10', False),
    ],
)
def test_a_last_value_may_be_cut_off_where_decimals_or_digits_are_missing(before, last, cut):
    lines = "".join(f"{i},{before[i % len(before)]}\n" for i in range(80))
    end = f"80,{last}"
    expected = (lines.encode(), last) if cut else ((lines + end).encode(), "")
    assert without_cut_line((lines + end).encode(), ",") == expected
    of_comma = (lines + end).replace(",", ";").replace(".", ",").encode()
    assert bool(without_cut_line(of_comma, ";", ",")[1]) == cut


def test_whole_numbers_are_held_to_those_just_before_and_few_lines_to_none():
    small, large = "".join(f"{i},7\n" for i in range(30)), "".join(f"{i},1012\n" for i in range(21))
    assert without_cut_line(f"{small}{large}9,10".encode(), ",")[1] == "10"
    assert without_cut_line(f"head\n{large[: 19 * 7]}9,10".encode(), ",")[1] == ""


def test_of_values_that_are_not_numbers_one_is_shown(tmp_path):
    rows = "".join(f"{i / 100:.2f},{100 + i % 7}.5{' bar' if i % 2 else ''}\n" for i in range(60))
    (tmp_path / "log.csv").write_text("time,p\n" + rows)
    found, _ = import_of(tmp_path / "log.csv")
    assert (
        found.findings.of("text")[0].detail
        == "such as '101.5 bar': numbers with their unit; leave 'bar' out of the cells"
    )
    assert found.findings.of("text")[0].count == 30


@pytest.mark.parametrize(
    ("head", "names", "unit"),
    [
        ("time,p\nTime since start,Pump pressure\n", ["time", "p"], ""),
        ("time,p\ns,bar\nTime since start,Pump pressure\n", ["time", "p"], "bar"),
        ("time,p\nTime since start,Pump pressure\ns,bar\n", ["time", "p"], "bar"),
        ("Pump,Boom\nTime s,Pump p\n", ["Time s", "Pump p"], ""),  # titles above the names
        ("Logger,7\ntime,p\n", ["time", "p"], ""),
    ],
)
def test_names_are_told_from_what_they_mean_and_from_titles(tmp_path, head, names, unit):
    (tmp_path / "log.csv").write_text(head + "".join(f"{k / 100:.2f},{k % 7}.5\n" for k in range(60)))
    with open_log(tmp_path / "log.csv") as log:
        assert [signal.name for signal in log.signals] == names
        assert log.signals[1].unit == unit


@pytest.mark.parametrize(
    ("first", "names"),
    [
        ("{k},{t:.2f},{p}", ["column 1", "time", "p"]),
        ("{k},2024-03-31 13:59:{t:05.2f},{p}", ["column 1", "time", "p"]),
        ("{k},{p},{t:.2f}", ["time", "p", "column 3"]),  # seconds that are numbered as rows are
        ("{t:.2f},{p},{k}", ["time", "p", "column 3"]),
    ],
)
def test_names_stand_over_their_columns_where_rows_begin_with_their_number(tmp_path, first, names):
    rows = "".join(first.format(k=k, t=k / 100, p=f"{k % 7}.5") + "\n" for k in range(60))
    (tmp_path / "log.csv").write_text("time,p\n" + rows)
    with open_log(tmp_path / "log.csv") as log:
        assert [signal.name for signal in log.signals] == names
