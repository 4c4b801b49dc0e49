import numpy as np
import pytest

from polydraulic.measure.checks.sentinel import Sentinels

WAVE = np.sin(np.arange(400) / 9.0)  # from -1 to 1


def found(value, parts=1):
    sentinels = Sentinels()
    for rows in np.array_split(np.arange(len(value)), parts):
        sentinels.add(value[rows], rows + 1)
    return [(number, count, rows.tolist()) for number, count, rows in sentinels.found()]


@pytest.mark.parametrize("parts", [1, 7, 400])
@pytest.mark.parametrize("number", [-9999.0, 32767.0, 7.1])
def test_a_number_far_away_that_comes_again_is_found_with_its_rows(number, parts):
    value = WAVE.copy()
    value[[0, 20, 21, 399]] = number
    assert found(value, parts) == [(number, 4, [1, 21, 22, 400])]


def test_both_ends_may_have_one():
    value = WAVE.copy()
    value[[5, 6]], value[[7, 8]] = 65535.0, -9999.0
    assert found(value, 3) == [(65535.0, 2, [6, 7]), (-9999.0, 2, [8, 9])]


def test_a_number_that_comes_once_is_near_or_is_0_is_none():
    for number, places in ((99.0, [5]), (6.9, [5, 6])):  # three times from -1 to 1 are 6
        value = WAVE.copy()
        value[places] = number
        assert found(value) == []
    value = WAVE + 100.0
    value[[5, 6]] = 0.0
    assert found(value) == []
    assert found(np.repeat([0.0, 24.0], 50)) == []
    assert found(WAVE[:0]) == []
