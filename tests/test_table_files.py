"""Tables as they lie in files: numbers handed to Arrow uncopied, missing ones as null and as empty cells."""

from io import StringIO

import numpy as np
import pyarrow as pa

from polydraulic.table_files import arrow_floats, write_rows


def test_columns_are_those_of_arrow_itself():
    matrix = np.arange(12.0).reshape(4, 3)
    matrix[1, 2] = np.nan
    schema = pa.schema([("a", pa.float64()), ("b", pa.float64())])
    found = arrow_floats([matrix[:, 0], matrix[::-1, 2]], schema)  # neither lies in one piece
    assert found.schema == schema
    assert found["a"].to_pylist() == [0.0, 3.0, 6.0, 9.0]
    assert np.array_equal(found["b"].to_numpy(), matrix[::-1, 2], equal_nan=True)
    assert found["b"].null_count == 0  # what is not a number is no missing value


def test_missing_values_are_null_where_that_is_asked_for():
    values = np.array([1.0, np.nan, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, np.nan])
    schema = pa.schema([("a", pa.float64()), ("b", pa.float64())])
    found = arrow_floats([values, np.arange(9.0)], schema, nulls=True)
    assert found["a"].to_pylist() == [1.0, None, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, None]
    assert found["b"].null_count == 0
    found.validate(full=True)


def test_missing_values_are_empty_cells_where_that_is_asked_for():
    columns = [np.array([1.0, np.nan]), np.array([np.nan, 0.1])]
    for empty, text in ((True, "1,\n,0.10000000000000001\n"), (False, "1,nan\nnan,0.10000000000000001\n")):
        file = StringIO()
        write_rows(file, columns, empty=empty)
        assert file.getvalue() == text
