import numpy as np
import pytest

from polydraulic.measure.formats.floats import as_floats


@pytest.mark.parametrize("kind", [np.int64, np.uint64])
def test_the_ends_of_64_bits_are_no_values(kind):
    limits = np.iinfo(kind)
    found = as_floats(np.array([limits.min, 7, limits.max], dtype=kind))
    assert found.tolist() == [-np.inf if limits.min else 0.0, 7.0, np.inf]


@pytest.mark.parametrize("kind", [np.int32, np.uint8, np.float32, bool])
def test_other_numbers_are_as_they_were(kind):
    values = np.array([0, 1, 1]).astype(kind)
    assert as_floats(values).tolist() == [0.0, 1.0, 1.0]
    assert as_floats(values).dtype == np.float64
