"""Curves that jets move: by shares of what flows leave unsure, as one beyond what was seen, and never falling."""

import numpy as np
import pytest

from polydraulic.identification.equations.circuits import ValveFound
from polydraulic.identification.equations.ways.curves_by_jets import jet_shares, moved_by_jets, none_moved
from polydraulic.parameters.layout.parts import ValveCurves

INLET, NONE = (0.0, 2.0, 4.0, 5.0), np.array([np.nan, np.nan, np.nan, np.nan])
CURVES = ValveCurves((0.0, 1e-3, 2e-3, 3e-3), INLET, (1.0, 0.0, 0.0, 0.0), INLET, INLET)
ERRORS = {"knots": np.zeros(4), "inlet": np.array([0.0, 0.2, 2.0, np.nan]), "bypass": np.zeros(4)}
ERRORS |= {"outlet_positive": np.array([0.0, 8.0, 0.0, np.nan]), "outlet_negative": NONE}
VALVE = ValveFound(CURVES, ERRORS, (0.0, 2e-3), (0.0, 1.0), 0.0, 0.0, 1000, (True, False))


def test_shares_are_errors_over_values_and_one_at_most():
    assert jet_shares(VALVE) == pytest.approx([0.0, 0.1, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, *np.zeros(4)])


def test_a_curve_moves_and_keeps_its_shape_beyond_what_was_seen():
    moved = none_moved(VALVE)
    moved[2] = -1.0
    found = moved_by_jets(VALVE, moved, np.full(12, 0.1))
    factor = np.exp(-0.5)
    assert found.curves.inlet == pytest.approx((0.0, 2.0, 4.0 * factor, 5.0 * factor))
    assert found.errors["inlet"][:3] == pytest.approx([0.0, 0.02, 4.0 * factor * 0.05])
    assert np.isnan(found.errors["inlet"][3])
    assert found.curves.outlet_positive == CURVES.outlet_positive
    assert found.curves.bypass == CURVES.bypass
    assert np.isnan(found.errors["outlet_negative"]).all()


def test_what_does_not_move_stays_as_it_is():
    found = moved_by_jets(VALVE, none_moved(VALVE), np.ones(12))
    assert found.curves == CURVES
    assert found.errors["inlet"] == pytest.approx(ERRORS["inlet"], nan_ok=True)


def test_a_curve_never_falls():
    moved = none_moved(VALVE)
    moved[2] = -3.0
    assert np.all(np.diff(moved_by_jets(VALVE, moved, np.ones(12)).curves.inlet) >= 0.0)
