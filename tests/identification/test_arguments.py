"""What the functions of identification take: tables in memory are held to the rules of tables in files."""

import numpy as np
import pytest

from polydraulic import InputError, Table, write_table
from polydraulic.identification.arguments import check_columns, table_of


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


def test_columns_that_cannot_be_learnt_are_named():
    table = Table({"a": np.arange(3.0), "b": np.full(3, 2.5)}, {"a": "m", "b": "Pa"})
    with pytest.raises(InputError, match="'a' is both input and output"):
        check_columns(table, ["a"], ["a"])
    with pytest.raises(InputError, match="column 'b' is 2.5 in all 3 rows; it cannot explain anything"):
        check_columns(table, ["b"], ["a"])
    with pytest.raises(InputError, match="it needs no model"):
        check_columns(table, ["a"], ["b"])
