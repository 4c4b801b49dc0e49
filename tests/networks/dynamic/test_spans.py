import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.networks.dynamic.spans import answered, blocks_of, lagged, rows_of, spans_of, stretches_of, without


def test_spans_end_at_labels_and_at_rows_that_are_not_known():
    known = np.array([True, True, False, False, True, True, True, True])
    assert spans_of(None, known) == [(0, 2), (4, 8)]
    assert spans_of([0, 0, 0, 0, 0, 1, 1, 0], known) == [(0, 2), (4, 5), (5, 7), (7, 8)]
    assert spans_of(None, np.zeros(3, dtype=bool)) == []
    with pytest.raises(InputError, match=r"segments has shape \(2,\)"):
        spans_of([1, 2], known)


def test_blocks_share_the_rows_and_keep_gaps():
    blocks = blocks_of([(0, 7), (10, 15)], 3)
    assert blocks == [[(0, 4)], [(4, 7), (10, 11)], [(11, 15)]]
    assert without([(0, 7), (10, 15)], blocks[1]) == [(0, 4), (11, 15)]
    assert without([(0, 7)], [(-3, 2), (6, 9)]) == [(2, 6)]


def test_lagged_rows_come_from_the_same_span():
    signals = np.arange(20.0).reshape(10, 2)
    spans = answered([(0, 4), (5, 7), (7, 10)], 2)
    assert spans == [(2, 4), (9, 10)]
    rows = rows_of(spans)
    assert np.array_equal(lagged(signals, [(0, 0), (1, 2)], rows), [[4.0, 1.0], [6.0, 3.0], [18.0, 15.0]])


def test_stretches_are_spans_of_about_one_length_or_blocks():
    even = [(0, 100), (110, 190), (200, 320)]
    assert stretches_of(even, 4) == [[span] for span in even]
    assert stretches_of([(0, 100)], 4) == blocks_of([(0, 100)], 4)
    uneven = [(0, 100), (110, 120)]
    assert stretches_of(uneven, 2) == blocks_of(uneven, 2)
    many = [(10 * n, 10 * n + 9) for n in range(11)]
    assert stretches_of(many, 4) == blocks_of(many, 4)


def test_each_of_several_logs_is_a_stretch_however_many_gaps_it_has():
    spans = [(0, 90), (100, 190), (200, 210), (210, 300)]
    logs = np.repeat([7, 3, 5], 100)
    assert stretches_of(spans, 4, logs) == [[(0, 90)], [(100, 190)], [(200, 210), (210, 300)]]
    assert stretches_of(spans, 4, np.zeros(300)) == stretches_of(spans, 4)
