"""Coordinates without bounds: whatever they are, the machine is possible."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.equations.numbers.unbounded import (
    from_unbounded,
    slopes_of_values,
    to_unbounded,
    unbounded,
    with_rises_open,
)

CURVES = ("functions.boom.valve.inlet", "functions.boom.valve.bypass")


def numbers_of(machine):
    spreads = {
        number.path: 0.3 * abs(number.value)
        for number in machine.numbers
        if number.value != 0.0 and (number.path.startswith("links.boom") or ".boom.friction." in number.path)
    }
    return unbounded(machine, {p: s for p, s in spreads.items() if ".at." not in p} | dict.fromkeys(CURVES, 1e-7))


def test_there_and_back():
    numbers = numbers_of(load_machine("cat215b_bucket"))
    u = to_unbounded(numbers, numbers.start)
    assert np.allclose(from_unbounded(numbers, u), numbers.start, rtol=1e-9)


def test_any_coordinates_make_a_possible_machine():
    machine, rng = load_machine("cat215b_bucket"), np.random.default_rng(0)
    numbers = numbers_of(machine)
    start = to_unbounded(numbers, numbers.start)
    for _ in range(20):
        values = from_unbounded(numbers, start + 3.0 * rng.normal(size=len(start)))
        there = machine.with_values(
            dict(zip(numbers.paths, values.tolist(), strict=True))
        )  # refuses what is not possible
        valve, friction = there.function("boom").valve, there.function("boom").friction
        assert np.all(np.diff(valve.inlet) >= 0.0)
        assert np.all(np.diff(valve.bypass) <= 0.0)
        assert friction.static > friction.coulomb > 0.0


def test_slopes_are_those_of_differences():
    numbers, rng = numbers_of(load_machine("cat215b_bucket")), np.random.default_rng(1)
    u = to_unbounded(numbers, numbers.start) + 0.1 * rng.normal(size=len(numbers.paths))
    found = slopes_of_values(numbers, u)
    for k, direction in enumerate(np.eye(len(u))):
        ahead, behind = (from_unbounded(numbers, u + way * direction) for way in (1e-5, -1e-5))
        assert np.allclose(found[:, k], (ahead - behind) / 2e-5, rtol=1e-5, atol=1e-6 * numbers.spread)


def test_a_rise_that_was_closed_is_opened_by_little_and_may_move_again():
    numbers = numbers_of(load_machine("cat215b_bucket"))
    start = to_unbounded(numbers, numbers.start)
    closed = np.where(numbers.rises, -20.0, start)
    opened = with_rises_open(numbers, closed)
    low, high = (
        np.diagonal(np.linalg.solve(numbers.sums, slopes_of_values(numbers, u))) / numbers.spread
        for u in (closed, opened)
    )
    assert np.all(low[numbers.rises] < 1e-4)
    assert np.all(high[numbers.rises] > 0.4)
    parts = np.linalg.solve(numbers.sums, from_unbounded(numbers, opened) - numbers.known)
    assert np.all(parts[numbers.rises] < 0.06 * numbers.spread[numbers.rises])
    assert np.array_equal(opened[~numbers.rises], start[~numbers.rises])
    assert np.array_equal(with_rises_open(numbers, np.abs(start)), np.abs(start))


def test_a_table_stands_for_its_numbers_that_are_not_zero():
    numbers = unbounded(load_machine("cat215b_bucket"), {CURVES[0]: 1e-7})
    assert numbers.paths == tuple(f"{CURVES[0]}[{k}]" for k in (2, 3, 4, 5))


@pytest.mark.parametrize(
    ("spreads", "said"),
    [
        ({}, "no number is free"),
        ({"links.boom.weight": 1.0}, "the machine has no such number"),
        ({"links.boom.mass": 0.0}, "must be positive and finite"),
        ({"links.boom.mass": float("nan")}, "must be positive and finite"),
    ],
)
def test_what_cannot_be_found_is_refused(spreads, said):
    with pytest.raises(InputError, match=said):
        unbounded(load_machine("cat215b_bucket"), spreads)
