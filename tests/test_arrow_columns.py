"""Numbers handed to Arrow as they lie in memory."""

import numpy as np
import pyarrow as pa

from polydraulic.arrow_columns import arrow_floats


def test_columns_are_those_of_arrow_itself():
    matrix = np.arange(12.0).reshape(4, 3)
    matrix[1, 2] = np.nan
    schema = pa.schema([("a", pa.float64()), ("b", pa.float64())])
    found = arrow_floats([matrix[:, 0], matrix[::-1, 2]], schema)  # neither lies in one piece
    assert found.schema == schema
    assert found["a"].to_pylist() == [0.0, 3.0, 6.0, 9.0]
    assert np.array_equal(found["b"].to_numpy(), matrix[::-1, 2], equal_nan=True)
    assert found["b"].null_count == 0  # what is not a number is no missing value
