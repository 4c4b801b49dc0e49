import numpy as np
import pytest

from polydraulic.measure.checks.excerpt import _PIECE, _PIECES, Excerpt

UNITS = {"time": "s", "segment": "1", "p": "Pa"}


def filled(n, block, segment=0.0):
    excerpt = Excerpt(UNITS)
    row = np.arange(float(n))
    for start in range(0, n, block):
        part = row[start : start + block]
        excerpt.add([part, np.full(len(part), segment), 2.0 * part])
    return excerpt


def test_a_short_table_is_kept_whole_whatever_the_blocks():
    for block in (1, 700, 5000):
        table = filled(4321 if block > 1 else 50, block).table()
        assert np.array_equal(table["time"], np.arange(len(table)))
        assert np.array_equal(table["p"], 2.0 * table["time"])
        assert set(table["segment"]) == {0.0}
        assert table.units == UNITS


def test_of_a_long_one_pieces_from_all_over_are_segments_of_their_own():
    n = 4 * _PIECE * _PIECES
    excerpt = filled(n, 50_000)
    table = excerpt.table()
    assert excerpt.n_row == n
    assert _PIECE * _PIECES // 2 <= len(table) <= _PIECE * (_PIECES + 1)
    assert table["time"][-1] > 0.98 * n
    leaps = np.diff(table["time"]) > 1.0
    assert leaps.any()
    assert np.array_equal(np.diff(table["segment"]) == 1.0, leaps)


@pytest.mark.parametrize(("n", "whole"), [(_PIECE * _PIECES, True), (_PIECE * (_PIECES + 1), False)])
def test_a_table_is_kept_whole_up_to_so_many_pieces(n, whole):
    table = filled(n, 90_000).table()
    assert len(table) == (n if whole else n // 2 + _PIECE // 2)
    pieces = table["time"].reshape(-1, _PIECE)
    assert np.array_equal(np.diff(pieces, axis=1), np.ones((len(pieces), _PIECE - 1)))
    assert np.array_equal(pieces[:, 0], np.arange(len(pieces)) * _PIECE * (1 if whole else 2))


def test_segments_of_the_log_stay_apart():
    excerpt = Excerpt(UNITS)
    for segment, start in ((3.0, 0), (5.0, 30)):
        row = np.arange(start, start + 30.0)
        excerpt.add([row, np.full(30, segment), row])
    assert excerpt.table()["segment"].tolist() == [0.0] * 30 + [1.0] * 30


def test_no_rows_are_an_empty_table():
    assert len(Excerpt(UNITS).table()) == 0
