"""One reading of the numbers of a whole column, from cells that come in any order."""

import numpy as np
import pyarrow as pa
import pytest

from polydraulic.columns.survey import Notation, TextColumn, survey


def read(cells, usual=".", blocks=2):
    parts = [{"a": pa.array(list(part), pa.string())} for part in np.array_split(np.array(cells, dtype=object), blocks)]
    reading = survey(parts, ["a"], usual)["a"]
    values, bad = reading.numbers(pa.array(cells, pa.string()))
    return values.tolist(), bad.tolist(), reading


@pytest.mark.parametrize(
    ("cells", "values", "kind"),
    [
        (["1.5", "2"], [1.5, 2.0], ""),
        (["1,5", "-2,25e3"], [1.5, -2250.0], ""),
        (["999,5", "1.002"], [999.5, 1002.0], "thousands"),
        (["1.002.000", "1.002"], [1002000.0, 1002.0], "thousands"),
        (["1.234,5", "0,25", "-12.345"], [1234.5, 0.25, -12345.0], "thousands"),
        (["1,234.5", "999.25", "1,002"], [1234.5, 999.25, 1002.0], "thousands"),
        (["1.002", "0.998"], [1.002, 0.998], ""),
        (["1.002", "999"], [1.002, 999.0], "doubtful numbers"),
        (["1.002", "9999"], [1.002, 9999.0], ""),
        (["1,002", "999"], [1.002, 999.0], "doubtful numbers"),
        (["true", "FALSE", "on", "Aus"], [1.0, 0.0, 1.0, 0.0], "on and off"),
        (["n/a", "-", "7"], [np.nan, np.nan, 7.0], ""),
    ],
)
def test_a_column_is_read_in_one_way(cells, values, kind):
    for order in (slice(None), slice(None, None, -1)):
        found, bad, reading = read(cells[order])
        assert found == pytest.approx(values[order], nan_ok=True)
        assert (bad, reading.kind) == ([], kind)


@pytest.mark.parametrize(
    ("cells", "bad", "kind"),
    [
        (["1,5", "2,5", "3.5"], [2], "decimal mark"),
        (["1.5", "2.5", "3,5"], [2], "decimal mark"),
        (["1,234", "2.345", "7"], [0], "decimal mark"),
        (["1.5", "OFF", "2"], [1], ""),
        (["on", "7"], [0], ""),
        (["1_000", "0x10", "٣", "5"], [0, 1, 2], ""),
    ],
)
def test_what_does_not_fit_the_reading_is_missing(cells, bad, kind):
    found, places, reading = read(cells)
    assert (places, reading.kind) == (bad, kind)
    assert np.isnan(found)[bad].all()


def test_words_for_on_and_off_wait_for_the_whole_column():
    asked = []

    def whole(reading):
        asked.append(reading)
        return reading

    words, numbers = pa.array(["off", "off"]), pa.array(["1.5", "off"])
    switch = TextColumn(Notation(), lambda: whole(Notation(switch=True, kind="on and off")))
    assert switch.numbers(words)[0].tolist() == [0.0, 0.0]
    sensor = TextColumn(Notation(), lambda: whole(Notation()))
    assert sensor.numbers(words)[1].tolist() == [0, 1]
    assert sensor.numbers(numbers)[1].tolist() == [1]
    assert len(asked) == 2
