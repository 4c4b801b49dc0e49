"""What the functions of identification take: tables in memory are held to the rules of tables in files."""

import numpy as np
import pytest

from polydraulic import InputError, Table, write_table
from polydraulic.identification.arguments import (
    check_columns,
    names_of_parts,
    parts_of,
    table_of,
    times_of_parts,
    unused_in_words,
    whole_rows,
)


def test_a_table_and_its_file_are_the_same_with_another_name(tmp_path):
    table = Table({"a": np.arange(3.0), "b": np.ones(3), "time": np.arange(3.0)}, {"a": "m", "b": "", "time": "s"})
    write_table(table, tmp_path / "t.parquet")
    there, name = table_of(tmp_path / "t.parquet", ["a"], ["time", "segment"])
    here, unnamed = table_of(table, ["a"], ["time", "segment"])
    assert list(here.names) == list(there.names) == ["a", "time"]
    np.testing.assert_array_equal(here["a"], there["a"])
    assert (name, unnamed) == ("t.parquet", "table")


def test_values_that_are_no_numbers_are_named_by_their_row():
    with pytest.raises(InputError, match="column 'a' holds nan in row 2 .1 of 3 rows."):
        table_of(Table({"a": np.array([0.0, np.nan, 1.0])}, {"a": "m"}))
    with pytest.raises(InputError, match="the table has no rows"):
        table_of(Table({"a": np.zeros(0)}, {"a": "m"}))


@pytest.mark.parametrize("given", [None, {"a": [1.0]}, [{"a": [1.0]}], 5, np.zeros((2, 2))])
def test_what_is_no_table_is_named(given):
    with pytest.raises(
        InputError, match="a table is given as a Table, a path, or a list of them, not as .*from_pandas"
    ):
        table_of(given)


def test_paths_may_come_from_a_generator(tmp_path):
    for n in range(2):
        write_table(Table({"a": np.arange(3.0) + n}, {"a": "m"}), tmp_path / f"{n}.parquet")
    assert len(table_of(sorted(tmp_path.glob("*.parquet")))[0]) == 6
    assert len(table_of(path for path in sorted(tmp_path.iterdir()))[0]) == 6


def test_columns_that_cannot_be_learnt_are_named():
    table = Table({"a": np.arange(3.0), "b": np.full(3, 2.5)}, {"a": "m", "b": "Pa"})
    with pytest.raises(InputError, match="'a' is both input and output"):
        check_columns(table, ["a"], ["a"])
    with pytest.raises(InputError, match="column 'b' is 2.5 in all 3 rows; it cannot explain anything"):
        check_columns(table, ["b"], ["a"])
    with pytest.raises(InputError, match="it needs no model"):
        check_columns(table, ["a"], ["b"])
    for given, message in (
        (([], ["a"]), r"no input is given; the table has \['a', 'b'\]"),
        ((["a"], []), "no output is given"),
        ((["a", "a"], ["b"]), "column 'a' is given twice as input"),
        ((["a"], ["b", "b"]), "column 'b' is given twice as output"),
    ):
        with pytest.raises(InputError, match=message):
            check_columns(table, *given)
    check_columns(Table({"a": np.ones(1), "b": np.ones(1)}, {}), ["a"], ["b"])  # one row is no constant


def log(begin=0.0, n=4, unit="m", info=None, segment=None, **more):
    time = begin + 0.1 * np.arange(n)
    columns = {"time": time, "a": 1e3 * begin + np.arange(n) + n, **more}
    if segment is not None:
        columns["segment"] = np.array(segment, dtype=float)
    return Table(columns, {"time": "s", "a": unit}, info or {})


def test_several_tables_are_one_whose_borders_are_kept(tmp_path):
    write_table(log(segment=[0, 0, 1, 1]), tmp_path / "day1.csv")
    write_table(log(n=3, segment=[5, 5, 5]), tmp_path / "day2.csv")
    for given in (
        [tmp_path / "day1.csv", tmp_path / "day2.csv"],
        [str(tmp_path / "day*.csv")],
        str(tmp_path / "day*.csv"),
    ):
        table, name = table_of(given, ["a"], ["time", "segment"])
        assert table["a"].tolist() == [4, 5, 6, 7, 3, 4, 5]
        assert table["segment"].tolist() == [0, 0, 1, 1, 2, 2, 2]
        assert table["time"] == pytest.approx([0, 0.1, 0.2, 0.3, 60.3, 60.4, 60.5])
        assert (name, parts_of(table), names_of_parts(table)) == (
            "day1.csv, day2.csv",
            [4, 3],
            ["day1.csv", "day2.csv"],
        )
    one, name = table_of([tmp_path / "day1.csv"], ["a"])
    assert (name, parts_of(one), names_of_parts(one)) == ("day1.csv", [4], [])


def test_tables_with_dates_are_in_their_order_and_times_stay(tmp_path):
    tables = [log(info={"began": 1.7e9 + 100.0}), log(info={"began": 1.7e9}, n=5)]
    table, name = table_of(tables)
    assert name == "table (2), table (1)"
    assert table["time"] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 100, 100.1, 100.2, 100.3])
    assert table.info["began"] == 1.7e9
    table, _ = table_of([log(1.7e9 + 60.0), log(1.7e9)])  # since 1970
    assert table["time"][[0, -1]] == pytest.approx([1.7e9, 1.7e9 + 60.3], abs=1e-6)
    with pytest.raises(
        InputError, match=r"table \(2\) begins 0.1 s before table \(1\) ends: the same time would count twice"
    ):
        table_of([log(1.7e9), log(1.7e9 + 0.2)])
    mixed, _ = table_of([log(info={"began": 1.7e9}), log(n=3)])
    assert "began" not in mixed.info


@pytest.mark.parametrize(("begin", "dated"), [(315_532_800.0, False), (315_532_801.0, True)])
def test_times_from_1980_on_are_dates(begin, dated):
    for info, own in (({}, begin), ({"began": begin}, 0.0)):
        later, first = log(own + 9.0, info=info), log(own, n=5, info=info)
        table, name = table_of([later, first])
        assert name == ("table (2), table (1)" if dated else "table (1), table (2)")
        assert table["time"][0] == own + (0.0 if dated else 9.0)
        last = 9.3 if dated else 9.3 + 60.0 + 0.4  # those that begin anew are a minute apart
        assert table["time"][-1] == pytest.approx(own + last, abs=1e-6)


def test_three_tables_are_in_the_name_of_several():
    assert table_of([log(n=n) for n in (3, 4, 5)])[1] == "table (1), table (2), table (3)"
    assert table_of([log(n=n) for n in (3, 4, 5, 6, 7)])[1] == "table (1), table (2), table (3) and 2 more"


def test_tables_without_times_are_put_together():
    table, _ = table_of([Table({"a": np.arange(3.0)}, {"a": "m"}), Table({"a": np.arange(2.0)}, {"a": "m"})])
    assert (table["a"].tolist(), table["segment"].tolist()) == ([0, 1, 2, 0, 1], [0, 0, 0, 1, 1])
    assert "time" not in table.names


def test_tables_that_do_not_belong_together_are_named(tmp_path):
    write_table(log(), tmp_path / "a.csv")
    write_table(log(n=5, b=np.ones(5)), tmp_path / "b.csv")
    write_table(log(n=5, unit="mm"), tmp_path / "mm.csv")
    write_table(Table({"a": np.arange(5.0)}, {"a": "m"}), tmp_path / "timeless.csv")
    write_table(log(), tmp_path / "twin.csv")

    def both(other, columns=None, optional=()):
        return table_of([tmp_path / "a.csv", tmp_path / other], columns, optional)

    for other, columns, optional, told in (
        ("b.csv", None, (), "a.csv: no column 'b', which b.csv has"),
        ("b.csv", ["a", "b"], (), "a.csv: no column 'b'; the table has"),
        ("timeless.csv", ["a"], ["time"], "timeless.csv: no column 'time', which a.csv has"),
        ("mm.csv", ["a"], (), "mm.csv: column 'a' is in 'mm', in a.csv in 'm'; bring them to one unit"),
        ("twin.csv", None, (), "twin.csv has the same rows as a.csv"),
        ("none.csv", None, (), "none.csv: no such file"),
        ("none*.csv", None, (), "none\\*.csv: no file matches"),
    ):
        with pytest.raises(InputError, match=told):
            both(other, columns, optional)
    with pytest.raises(InputError, match="no table is given"):
        table_of([])
    with pytest.raises(InputError, match="column 'time' is an input: of several tables"):
        check_columns(table_of([log(), log(n=5)])[0], ["time"], ["a"])


def test_of_declared_missing_values_come_whole_rows_or_all_of_them(tmp_path):
    nan = np.nan
    silent = Table(
        {"time": np.arange(4.0), "segment": np.zeros(4), "a": np.array([1.0, nan, 3.0, 4.0]), "b": np.full(4, nan)}, {}
    ).partial()
    write_table(silent, tmp_path / "a.parquet")
    for given in (silent, tmp_path / "a.parquet"):
        table, _ = table_of(given, ["time", "a"], ["segment"])
        assert table.names == ["time", "a", "segment"]
        assert table["segment"].tolist() == [0.0, 1.0, 1.0]
        every, _ = table_of(given, ["time", "a"], ["segment"], partial=True)
        assert every["missing"].tolist() == [0.0, 1.0, 0.0, 0.0]
        with pytest.raises(InputError, match="no row has a value of all of time, a, b; 'b' has one in 0 of 4"):
            table_of(given, ["time", "a", "b"])
        with pytest.raises(InputError, match="no column 'c'"):
            table_of(given, ["c"], partial=True)


def test_of_several_tables_those_with_missing_values_declare_them():
    whole = Table({"time": np.arange(3.0), "a": np.ones(3)}, {})
    silent = Table({"time": np.arange(3.0), "a": np.array([1.0, np.nan, 2.0])}, {}).partial()
    joined, _ = table_of([whole, silent], partial=True)
    assert joined["missing"].tolist() == [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    rows, _ = table_of([whole, silent])
    assert rows["a"].tolist() == [1.0, 1.0, 1.0, 1.0, 2.0]
    assert parts_of(rows) == [3, 2]


def test_whole_rows_of_several_tables_still_know_which_these_were():
    nan = np.nan
    parts = [
        Table({"time": np.arange(3.0), "a": np.array([1.0, nan, 3.0])}, {}).partial(),
        Table({"time": np.arange(3.0), "a": np.full(3, nan)}, {}).partial(),
        Table({"time": np.arange(2.0), "a": np.ones(2)}, {}),
    ]
    joined, _ = table_of(parts, partial=True)
    rows = whole_rows(joined, ["time", "segment", "a"])
    assert parts_of(rows) == [2, 2]
    assert names_of_parts(rows) == ["table (1)", "table (3)"]
    first, third = times_of_parts(rows)
    assert (first.begins, first.shift) == (0.0, 0.0)
    assert third.begins == third.shift == rows["time"][2]
    assert whole_rows(joined, ["time"]).info == joined.info


def test_rows_that_are_left_out_are_counted_by_what_they_lack(tmp_path):
    nan = np.nan
    silent = Table(
        {"time": np.arange(4.0), "a": np.array([1.0, nan, nan, 4.0]), "b": np.array([nan, 1.0, nan, 1.0])}, {}
    )
    write_table(silent.partial(), tmp_path / "a.parquet")
    for given in (silent.partial(), tmp_path / "a.parquet"):
        table, _ = table_of(given)
        words = "3 of 4 rows are not used, since columns that are read have no value there: a in 2, b in 2"
        assert unused_in_words(table) == words
        assert unused_in_words(table_of(table)[0]) == ""  # nothing more is left out of it
        assert unused_in_words(table_of(given, ["a"], ["time"])[0]).startswith("2 of 4 rows are not used")
        assert unused_in_words(table_of(given, ["time"])[0]) == ""
        assert unused_in_words(table_of(given, partial=True)[0]) == ""
    whole = Table({"time": np.arange(9.0, 12.0), "a": np.ones(3), "b": np.ones(3)}, {})
    both, _ = table_of([silent.partial(), whole, Table(silent.columns | {"a": np.full(4, 2.0)}, {}).partial()])
    assert unused_in_words(both).startswith("5 of 11 rows are not used")
    assert unused_in_words(both).endswith("there: a in 2, b in 4")
