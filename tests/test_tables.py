import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.files import replacing
from polydraulic.tables import Table, began, read_table, shown_column, shown_table, write_table
from polydraulic.thesis.printed_units import in_field_units
from polydraulic.units import PSI

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
        ("x,x [m]\n1,2\n", "column 'x' appears twice"),
        ("x,y\n1\n", "cannot be read as a csv table"),
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
