import re
import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from polydraulic.errors import InputError
from polydraulic.files import replacing
from polydraulic.tables import Table, began, read_table, shown_column, shown_table, write_table
from polydraulic.thesis.printed_units import in_field_units
from polydraulic.unit_table import PSI

TABLE = Table({"t": np.array([0.0, 0.1, 1 / 3]), "p x": np.array([1e-300, -2.0, 3e200])}, {"t": "s"}, {"n": 3})


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_reading_gives_what_was_written(tmp_path, ending):
    path = tmp_path / "deep" / f"table.{ending}"
    write_table(TABLE, path)
    found = read_table(path)
    assert found.names == TABLE.names
    assert all(np.array_equal(found[name], TABLE[name]) for name in TABLE.names)
    assert found.unit("t") == "s"
    assert found.unit("p x") == ""
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_parquet_keeps_what_made_the_table(tmp_path):
    write_table(TABLE, tmp_path / "a.parquet")
    assert read_table(tmp_path / "a.parquet").info == {"n": 3}


def test_only_the_columns_asked_for_are_checked(tmp_path):
    (tmp_path / "a.csv").write_text("x,y\n1,2\n2,nan\n")
    assert read_table(tmp_path / "a.csv", ["x"]).names == ["x"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y\n1,2\n3,nan\n", "column 'y' holds nan in row 2"),
        ("x,y\n1,inf\n3,4\n", "column 'y' holds inf in row 1"),
        ("x,y\n1,2\n3,\n", "column 'y' holds nan in row 2"),
        ("x,y\n1,red\n3,blue\n", "column 'y' holds 'red'"),
        ("x,y\n1,\n3,\n", "column 'y' holds no value .null.; every value"),
        ("x,x [m]\n1,2\n", "column 'x' appears twice"),
        ("x,y\n1\n", "cannot be read as a csv table"),
        (
            "t [s];p [bar]\n0,0;1,5\n0,1;1,6\n",
            "cannot be read as a csv table .*; a log as .* goes through `polydraulic import` first",
        ),
        ("t [s];p [bar]\n0;1\n", "every value must be a number; a log as .* goes through `polydraulic import` first"),
        ("x,y\n1,\n3,4\n", "drop these rows or fill them first; a log as .* goes through `polydraulic import` first"),
        ("", "cannot be read as a csv table"),
    ],
)
def test_bad_tables_are_named(tmp_path, text, message):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_table(path)


def test_missing_things_are_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_table(tmp_path / "none.csv")
    write_table(TABLE, tmp_path / "a.csv")
    with pytest.raises(InputError, match=r"no column 'q'; the table has \['t', 'p x'\]"):
        read_table(tmp_path / "a.csv", ["q"])
    (tmp_path / "b.csv").write_text("t;p\n0;1\n")
    with pytest.raises(
        InputError, match=r"no column 'p'; .*\['t;p'\]; a log as .* goes through `polydraulic import` first"
    ):
        read_table(tmp_path / "b.csv", ["p"])
    with pytest.raises(InputError, match="no column 'q'"):
        TABLE["q"]
    with pytest.raises(InputError, match="ends in .csv or .parquet"):
        write_table(TABLE, tmp_path / "a.xls")


def test_a_damaged_parquet_file_is_one_error(tmp_path):
    (tmp_path / "a.parquet").write_bytes(b"PAR1 nonsense")
    with pytest.raises(InputError, match="cannot be read as a parquet table"):
        read_table(tmp_path / "a.parquet")


def test_an_interrupted_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), replacing(path) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_unwritable_folder_is_one_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write_table(TABLE, tmp_path / "file" / "a.csv")


def test_names_with_commas_and_quotes_come_back(tmp_path):
    table = Table({"stiff, 10 l": np.arange(3.0), 'the "fast" one': np.ones(3)}, {"stiff, 10 l": "psi"})
    write_table(table, tmp_path / "t.csv")
    again = read_table(tmp_path / "t.csv")
    assert again.names == table.names
    assert again.unit("stiff, 10 l") == "psi"


def test_a_table_is_read_by_names_and_its_length_is_rows():
    assert list(TABLE) == TABLE.names == ["t", "p x"]
    assert "t" in TABLE
    assert "q" not in TABLE
    assert len(TABLE) == 3
    assert len(Table({}, {})) == 0


def test_tables_are_equal_by_names_units_and_values():
    def made(**other):
        return Table.from_dict({"a": [1.0, np.nan], "b": [2.0, 3.0]} | other, {"a": "m", "b": "s"})

    assert made() == made()
    assert made() == Table(made().columns, {"a": "m", "b": "s"}, {"made": "later"})
    assert made() != made(b=[2.0, 4.0])
    assert made() != made(a=[1.0, 0.0])
    assert made() != Table(made().columns, {"a": "mm", "b": "s"})
    assert made() != Table(dict(reversed(made().columns.items())), made().units)
    assert made() != Table({"a": made()["a"]}, {"a": "m"})
    assert Table(made().columns, {"a": "", "b": ""}) == Table(made().columns, {})
    assert made() != "a table"
    with pytest.raises(TypeError, match="unhashable"):
        {made()}


def test_arrow_and_pandas_give_back_what_they_got():
    table = Table(TABLE.columns | {"q": np.array([1.0, np.nan, np.inf])}, TABLE.units, TABLE.info)
    for found in (Table.from_arrow(table.to_arrow()), Table.from_pandas(table.to_pandas())):
        assert found == table
        assert found.info == {"n": 3}
        found["t"][0] = 5.0  # a copy, which may be written
    assert table["t"][0] == 0.0
    assert table.to_pandas().attrs["units"] == {"t": "s", "p x": "", "q": ""}
    assert table.to_pandas()["p x"].tolist() == table["p x"].tolist()


def test_arrow_tables_and_parquet_files_keep_units_in_one_way(tmp_path):
    write_table(TABLE, tmp_path / "a.parquet")
    assert pq.read_table(tmp_path / "a.parquet").schema.equals(TABLE.to_arrow().schema, check_metadata=True)
    pq.write_table(TABLE.to_arrow(), tmp_path / "b.parquet")
    assert read_table(tmp_path / "b.parquet") == TABLE


def test_data_frames_of_other_kinds_are_read():
    frame = pd.DataFrame({"a": pd.array([1, None], dtype="Int64"), 3: np.float32([0.5, 1.5])}, index=[7, 9])
    found = Table.from_pandas(frame, {"3": "m"})
    assert found == Table({"a": np.array([1.0, np.nan]), "3": np.array([0.5, 1.5])}, {"a": "", "3": "m"})
    part = TABLE.to_pandas()[["p x"]]  # a part keeps the units of all
    assert Table.from_pandas(part).units == {"p x": ""}


def test_numbers_of_any_kind_become_columns():
    found = Table.from_dict(
        {"a": [1, 2.5, None], "b": range(3), "c": np.arange(3, dtype=np.uint8)}, {"b": "s"}, {"n": 1}
    )
    assert np.array_equal(found["a"], [1.0, 2.5, np.nan], equal_nan=True)
    assert [found[name].dtype for name in found] == [np.float64] * 3
    assert found.units == {"a": "", "b": "s", "c": ""}
    assert found.info == {"n": 1}


@pytest.mark.parametrize(
    ("columns", "units", "message"),
    [
        ({"a": ["x", "y"]}, {}, r"column 'a' holds 'x' \(string\); every value must be a number"),
        ({"a": pd.Categorical([10, 20])}, {}, r"column 'a' holds '10' \(dictionary.*\); every value must be a number"),
        ({"a": [True, False]}, {}, "column 'a' holds 'True'"),
        ({"a": np.zeros((2, 2))}, {}, "column 'a' is not a sequence of numbers"),
        ({"a": 3.0}, {}, "column 'a' is not a sequence of numbers"),
        ({"a": [1.0, "x"]}, {}, "column 'a' is not a sequence of numbers"),
        ({"a": [2**53 + 1]}, {}, "column 'a' holds whole numbers beyond 2.53"),
        ({"a": [1.0], "b": [1.0, 2.0]}, {}, "the columns have {'a': 1, 'b': 2} rows; they must be equally long"),
        ({"a": [1.0]}, {"a": None}, "unit of column 'a', None: must be a string"),
        ({"a": [1.0]}, {"b": "s"}, "a unit is given for the column 'b'; the table has .'a'."),
    ],
)
def test_what_is_no_table_is_one_clear_error(columns, units, message):
    with pytest.raises(InputError, match=message):
        Table.from_dict(columns, units)


@pytest.mark.parametrize(("of_field", "of_schema"), [({"unit": b"\xff"}, {}), ({}, {"polydraulic": "{"})])
def test_damaged_metadata_is_one_clear_error(of_field, of_schema):
    schema = pa.schema([pa.field("a", pa.float64(), metadata=of_field)], metadata=of_schema)
    with pytest.raises(InputError, match="metadata of the table are damaged"):
        Table.from_arrow(pa.table([[1.0]], schema=schema))


def test_names_that_stand_twice_are_refused():
    with pytest.raises(InputError, match="column '1' appears twice"):
        Table.from_pandas(pd.DataFrame([[1.0, 2.0]], columns=[1, "1"]))
    with pytest.raises(InputError, match="column 'a' appears twice"):
        Table.from_arrow(pa.table([[1.0], [2.0]], names=["a", "a"]))
    with pytest.raises(InputError, match="column 'a' holds '2020-01-01 00:00:00'"):
        Table.from_pandas(pd.DataFrame({"a": [pd.Timestamp("2020-01-01")]}))


def test_whole_numbers_that_are_no_floats_are_refused_in_files(tmp_path):
    pq.write_table(pa.table({"a": pa.array([2**53 + 1])}), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="a.parquet: column 'a' holds whole numbers beyond 2.53"):
        read_table(tmp_path / "a.parquet")


def test_a_table_shows_names_units_and_both_ends():
    many = Table.from_dict({"<t>": np.arange(1000) / 4, **{f"c{k}": np.ones(1000) for k in range(40)}}, {"<t>": "s"})
    shown = repr(many)
    assert shown.splitlines()[:2] == ["Table of 1000 rows and 41 columns", "  <t> [s]  0 ... 249.75"]
    assert shown.splitlines()[-1] == "  and 11 more"
    page = many._repr_html_()
    assert "<caption>1000 rows, 41 columns, the first shown</caption>" in page
    assert "<th>&lt;t&gt; [s]</th>" in page
    rows = [re.findall(r"<td[^>]*>([^<]*)</td>", row) for row in page.split("<tr>")[2:]]
    assert [row[0] for row in rows] == ["0", "1", "2", "3", "4", "...", "995", "996", "997", "998", "999"]
    assert rows[6][:3] == ["995", "248.75", "1"]
    assert rows[5][1] == "..."
    assert repr(Table.from_dict({"a": [2]})) == "Table of 1 rows and 1 columns\n  a  2"
    assert repr(Table.from_dict({"a": []})) == "Table of 0 rows and 1 columns\n  a"
    assert Table.from_dict({"a": [2]})._repr_html_().count("<tr>") == 2


def test_pandas_is_asked_for_by_name_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(
        InputError, match=r"pandas is not installed; install it with: pip install 'polydraulic\[pandas\]'"
    ):
        TABLE.to_pandas()


def test_tables_are_shown_column_by_column():
    table = Table({"p": np.array([1e5, 2e5]), "q": np.ones(2)}, {"p": "Pa", "q": "gal"}, {"source": "log"})
    values, unit = shown_column(table, "p", "metric")
    assert (values.tolist(), unit) == ([1.0, 2.0], "bar")
    printed, unit = in_field_units(table, "p")
    assert (printed[1], unit) == (2e5 / PSI, "psi")
    read = shown_table(table)
    assert (read["p"].tolist(), read["q"].tolist()) == ([1.0, 2.0], [1.0, 1.0])
    assert (read.units, read.info) == ({"p": "bar", "q": "gal"}, {"source": "log"})


def test_when_a_log_began():
    assert began(Table({}, {}, {"began": 1.7e9})) == 1.7e9
    assert began(Table({}, {})) == began(Table({}, {}, {"began": "noon"})) == 0.0


@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_names_of_columns_travel_or_are_refused_before_anything_is_written(ending, tmp_path):
    path = tmp_path / f"t{ending}"
    names = [
        "lambda",
        "None",
        "p / bar",
        "a,b",
        'a"b',
        "%",
        "$x",
        r"\\frac",
        "p_{",
        "two\nlines",
        "Ünï🙂",
        "x" * 300,
        "A",
        "a",
        "=1+1",
    ]
    table = Table.from_dict(
        {name: [float(k), 2.5] for k, name in enumerate(names)}, {"lambda": "m3/s", "a,b": "bar", "two\nlines": "V"}
    )
    write_table(table, path)
    assert read_table(path) == table
    for name in ("", " ", "a\x00", "\ud800", "\uffff"):
        with pytest.raises(InputError, match="column "):
            write_table(Table.from_dict({name: [1.0]}), tmp_path / f"other{ending}")
    if ending == ".csv":
        for name, unit in (("p [bar]", ""), (" p", ""), ("p", "a]b")):
            with pytest.raises(InputError, match="would be misread from CSV"):
                write_table(Table.from_dict({name: [1.0]}, {name: unit}), tmp_path / "other.csv")
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("value", [np.ones(3), np.int64(1), {1.0, 2.0}, {"deep": [np.ones(2)]}])
def test_information_that_no_file_keeps_is_named_and_nothing_is_written(tmp_path, value):
    table = Table({"x": np.ones(1)}, {}, {"n": 1, "gains": value})
    with pytest.raises(InputError, match=r"info\['gains'\] of the table is .*: convert it first"):
        table.to_arrow()
    with pytest.raises(InputError, match=r"info\['gains'\]"):
        write_table(table, tmp_path / "a.parquet")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "metadata"),
    [("x", {b"polydraulic": b"[1]"}), ("x", {b"polydraulic": b"{"}), ("x", {b"polydraulic": b"\xff"}), ("x", {b"polydraulic": b"[" * 100_000})],
)  # fmt: skip
def test_damaged_information_of_a_table_is_one_error(tmp_path, name, metadata):
    pq.write_table(pa.table({name: [1.0]}).replace_schema_metadata(metadata), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="a.parquet: cannot be read as a parquet table"):
        read_table(tmp_path / "a.parquet")


def test_names_and_units_that_are_no_text_are_one_error(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"x\xff,y\n1,2\n")
    with pytest.raises(InputError, match="a.csv: cannot be read as a csv table"):
        read_table(tmp_path / "a.csv")
    fields = [pa.field("x", pa.float64(), metadata={b"unit": b"\xff"})]
    pq.write_table(pa.table([[1.0]], schema=pa.schema(fields)), tmp_path / "a.parquet")
    with pytest.raises(InputError, match="a.parquet: cannot be read as a parquet table"):
        read_table(tmp_path / "a.parquet")


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_table_without_columns_is_not_written(tmp_path, ending):
    with pytest.raises(InputError, match="the table has no columns to write"):
        write_table(Table({}, {}), tmp_path / f"t.{ending}")


def test_whole_numbers_that_no_float_holds_are_named():
    with pytest.raises(InputError, match="column 'a' is not a sequence of numbers"):
        Table.from_dict({"a": [2**70]})


def partly_silent():
    """Seven rows, of which `a` and `b` lack some at different times."""
    nan = np.nan
    columns = {
        "time": np.arange(7) * 0.1,
        "segment": np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]),
        "a": np.array([1.0, 2.0, nan, 4.0, 5.0, 6.0, 7.0]),
        "b": np.array([nan, 2.0, 3.0, 4.0, 5.0, 6.0, nan]),
    }
    return Table(columns, {"time": "s", "segment": "1", "a": "m", "b": ""}, {"n": 1})


def test_declared_missing_values_are_counted_by_row():
    table = partly_silent().partial()
    assert table["missing"].tolist() == [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    assert table.unit("missing") == "1"
    assert table.partial() == table
    assert table.known(["a"]).tolist() == [True, True, False, True, True, True, True]
    for some in (table, Table({"a": np.zeros(3)}, {})):
        with pytest.raises(InputError, match="no column 'c'"):
            some.known(["a", "c"])


def test_whole_rows_are_those_of_the_columns_asked_for_and_segments_are_cut():
    table = partly_silent().partial()
    of_a = table.whole(["time", "segment", "a"])
    assert of_a.names == ["time", "segment", "a"]
    assert of_a["a"].tolist() == [1.0, 2.0, 4.0, 5.0, 6.0, 7.0]
    assert of_a["segment"].tolist() == [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]
    of_both = table.whole(["time", "segment", "a", "b"])
    assert of_both["time"] == pytest.approx([0.1, 0.3, 0.4, 0.5])
    assert of_both["segment"].tolist() == [0.0, 1.0, 1.0, 2.0]
    assert (of_both.unit("a"), of_both.info) == ("m", {"n": 1})
    alone = table.whole(["time", "segment"])
    assert alone["segment"].tolist() == partly_silent()["segment"].tolist()
    assert TABLE.whole(TABLE.names) == TABLE


def test_a_column_that_lacks_values_is_not_given_silently():
    table = partly_silent().partial()
    with pytest.raises(InputError, match=r"column 'b' has no value in 2 of 7 rows; take whole rows .* table.whole"):
        table["b"]
    with pytest.raises(InputError, match="column 'a' has no value in 1 of 7 rows"):
        table.matrix(["time", "a"])
    assert np.isnan(table.columns["b"][0])
    assert "nan" in repr(table)
    assert "nan" in table._repr_html_()
    silent = Table.from_dict({"time": [0.0, 1.0], "a": [np.nan, 1.0], "b": [1.0, np.nan]}).partial()
    with pytest.raises(InputError, match="no row has a value of all of a, b; 'a' has one in 1 of 2"):
        silent.whole(["a", "b"])


@pytest.mark.parametrize(("name", "value"), [("time", np.nan), ("segment", np.nan), ("a", np.inf)])
def test_times_segments_and_infinite_values_cannot_be_missing(name, value):
    table = partly_silent()
    table.columns[name][1] = value
    with pytest.raises(InputError, match=f"column '{name}' holds (nan|inf) in row 2"):
        table.partial()


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_declared_missing_values_are_written_and_read(tmp_path, ending):
    table, path = partly_silent().partial(), tmp_path / f"a.{ending}"
    write_table(table, path)
    assert read_table(path, partial=True) == table
    assert read_table(path) == table.whole(["time", "segment", "a", "b"])
    assert read_table(path, ["a"], optional=["segment"]) == table.whole(["a", "segment"])
    some = read_table(path, ["time"], optional=["b"], partial=True)
    assert some.names == ["time", "b", "missing"]
    assert some["missing"].tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    if ending == "parquet":
        assert pq.read_table(path)["b"].null_count == 2
    else:
        assert path.read_text().splitlines()[1] == "0,0,1,,1"


def test_missing_values_that_are_not_declared_or_miscounted_are_refused(tmp_path):
    table, path = partly_silent().partial(), tmp_path / "a.parquet"
    table["missing"][1] = 1.0
    write_table(table, path)
    for partial in (False, True):
        with pytest.raises(InputError, match="column 'missing' must count the values that the other columns lack"):
            read_table(path, partial=partial)
    write_table(partly_silent(), path)
    with pytest.raises(InputError, match="column 'b' holds nan in row 1 .2 of 7 rows."):
        read_table(path, ["b"], partial=True)


def test_declared_missing_values_survive_pandas_and_arrow():
    table = partly_silent().partial()
    assert table.to_arrow()["a"].null_count == 1
    assert Table.from_arrow(table.to_arrow()) == table
    assert Table.from_pandas(table.to_pandas()) == table
