"""Rows that are held out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.errors import InputError
from polydraulic.networks.hold_out import (
    BLOCKS,
    blocks_of_parts,
    calibration_rows,
    drawn_rows,
    held_blocks,
    held_distinct_rows,
    held_rows,
)


@given(st.integers(0, 200), st.integers(0, 200), st.integers(0, 5))
def test_drawn_rows_are_all_rows_once(n, n_held, seed):
    n_held = min(n, n_held)
    learn, hold = drawn_rows(n, n_held, seed)
    assert (len(learn), len(hold)) == (n - n_held, n_held)
    assert sorted([*learn, *hold]) == list(range(n))


def test_rows_of_a_calibration_keep_their_order():
    learn, hold = calibration_rows(100, 0.3, 0)
    assert len(hold) == 30
    assert np.all(np.diff(learn) > 0)
    assert np.all(np.diff(hold) > 0)
    assert sorted(drawn_rows(100, 30, 0)[1]) == hold.tolist()
    assert not np.array_equal(hold, calibration_rows(100, 0.3, 1)[1])


def test_without_a_calibration_nothing_is_drawn():
    state = np.random.RandomState(0)
    learn, hold = calibration_rows(10, 0.0, state)
    assert (learn.tolist(), hold.tolist()) == (list(range(10)), [])
    assert state.rand() == np.random.RandomState(0).rand()
    for share in (-0.1, 1.0):
        with pytest.raises(InputError, match=f"calibration = {share}: must be a share of the rows"):
            calibration_rows(10, share, 0)


def test_every_fifth_row_or_block_is_held_out():
    assert np.flatnonzero(held_rows(12)).tolist() == [4, 9]
    assert np.flatnonzero(held_rows(20, 10)).tolist() == [8, 9, 18, 19]
    assert held_rows(0, 20).shape == (0,)
    assert held_blocks("abcdefghijk") == ["e", "j"]


@given(st.integers(100, 1000), st.integers(1, 100))
def test_blocks_are_as_long_as_each_other(n, blocks):
    held = held_rows(n, blocks)
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]]))))[::2]
    assert len(runs) == blocks // 5
    assert set(runs) <= {n // blocks, n // blocks + 1}


@given(st.lists(st.integers(1, 300), min_size=1, max_size=30), st.integers(1, 100))
def test_no_block_goes_over_the_end_of_a_part(parts, blocks):
    counts = blocks_of_parts(blocks, parts)
    assert min(counts) >= 1
    assert abs(sum(counts) - blocks) <= len(parts)
    held, before, ends = held_rows(sum(parts), blocks, parts), 0, np.cumsum([0, *parts])
    for low, high, count in zip(ends[:-1], ends[1:], counts, strict=True):
        number = before + np.arange(high - low) * count // (high - low)  # blocks begin with their part
        assert np.array_equal(held[low:high], number % 5 == 4)
        before += count


@given(st.lists(st.integers(0, 40), min_size=30, max_size=200))
def test_copies_are_held_out_together(numbers):
    distinct = list(dict.fromkeys(numbers))
    values = np.c_[np.array(numbers), np.array(numbers) % 3]
    if len(distinct) < 14:
        with pytest.raises(
            InputError, match=f"of which {len(distinct)} differ; fitting and holding out takes 14 or more"
        ):
            held_distinct_rows(values, 12)
        return
    assert held_distinct_rows(values, 12).tolist() == [distinct.index(n) % 5 == 4 for n in numbers]


def test_rows_that_all_differ_are_held_out_as_they_come():
    values = np.random.default_rng(0).normal(size=(1000, 3))
    assert np.array_equal(held_distinct_rows(values, 12), held_rows(1000))
    zeros = np.r_[np.arange(4.0, 0.0, -1.0), 0.0, -0.0, np.arange(5.0, 11.0)]
    assert np.flatnonzero(held_distinct_rows(zeros[:, None], 8)).tolist() == [4, 5, 10]


@given(st.integers(2, 60))
def test_as_many_rows_as_learning_takes_are_left(fewest):
    with pytest.raises(InputError) as refused:
        held_distinct_rows(np.zeros((1, 1)), fewest)
    least = int(str(refused.value).split()[-3])
    for n in range(least, least + 6):
        assert (~held_distinct_rows(np.arange(float(n))[:, None], fewest)).sum() >= fewest
    with pytest.raises(InputError, match=f"takes {least} or more"):
        held_distinct_rows(np.arange(least - 1.0)[:, None], fewest)
    assert least == 10 or (~held_rows(least - 1)).sum() < fewest


def test_a_single_part_has_the_blocks_of_all_rows():
    assert np.array_equal(held_rows(317, 20, [317]), held_rows(317, 20))


def test_every_part_has_a_block():
    assert blocks_of_parts(20, [1]) == [20]
    assert blocks_of_parts(20, [0, 1, 99, 100]) == [1, 1, 10, 10]
    assert blocks_of_parts(20, [0]) == [1]


def test_four_of_the_twenty_blocks_of_a_log_are_held_out():
    assert np.flatnonzero(held_rows(1000, BLOCKS).reshape(20, 50).all(axis=1)).tolist() == [4, 9, 14, 19]
    assert held_rows(1000, BLOCKS).sum() == 200


def test_two_rows_that_differ_are_held_out_at_least_and_numbers_differ_however_small():
    small = 1e-20 * np.arange(10.0)[:, None]
    assert held_distinct_rows(small, 1).tolist() == [k % 5 == 4 for k in range(10)]
    with pytest.raises(InputError, match="^the table has 9 rows; fitting and holding out takes 10 or more$"):
        held_distinct_rows(small[:9], 1)
    with pytest.raises(InputError, match="^the table has 11 rows, of which 9 differ; fitting and holding out takes 10"):
        held_distinct_rows(np.concatenate([small[:9], small[:1], -small[:1]]), 1)
