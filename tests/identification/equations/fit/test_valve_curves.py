import numpy as np

from polydraulic.identification.equations.fit.valve_curves import (
    Curves,
    at_place,
    falling,
    placed_among,
    rising,
    with_knot,
)

KNOTS = np.array([0.0, 1.0, 3.0, 4.0])


def test_values_are_linear_between_knots_and_constant_beyond():
    values, at = np.array([0.0, 2.0, 4.0, 4.0]), np.array([0.0, 0.5, 2.0, 4.0, 9.0])
    place = placed_among(KNOTS, at)
    assert np.allclose(at_place(values, place), np.interp(at, KNOTS, values))


def test_rises_and_falls_give_monotone_values():
    assert (rising(4) @ [1.0, 0.0, 2.0]).tolist() == [0.0, 1.0, 1.0, 3.0]
    assert (falling(4) @ [1.0, 0.0, 2.0, 0.5]).tolist() == [3.5, 2.5, 2.5, 0.5]


def test_one_more_knot_leaves_the_curves_as_they_are():
    before = Curves(KNOTS, np.array([0.0, 0.0, 2.0, 9.0]), np.array([8.0, 3.0, 0.0, 0.0]))
    after, at = with_knot(before, 2.2), np.linspace(0.0, 4.0, 50)
    assert after.knots.tolist() == [0.0, 1.0, 2.2, 3.0, 4.0]
    for old, new in ((before.inlet, after.inlet), (before.bypass, after.bypass)):
        assert np.allclose(np.interp(at, KNOTS, old), np.interp(at, after.knots, new))
