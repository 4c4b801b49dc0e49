"""Curves from flows of circuits whose curves are known; knots that are missing are found."""

import numpy as np
import pytest

from polydraulic.identification.equations.fit.circuit_fit import (
    CircuitModel,
    CircuitRows,
    Prior,
    fit_circuit,
    flows_of,
    measured_flows,
    moved,
    normal,
)
from polydraulic.identification.equations.fit.knots import grow
from polydraulic.identification.equations.fit.uncertainty import circuit_errors
from polydraulic.identification.equations.fit.valve_curves import Curves
from polydraulic.machine.pump import Pump

TRUE = Curves(
    np.array([0.0, 4.8e-3, 7.2e-3, 9.5e-3, 14e-3]),
    np.array([0.0, 0.0, 6e-7, 9e-7, 5e-6]),
    np.array([3e-6, 8e-7, 2e-7, 0.0, 0.0]),
)
START = Curves(
    np.array([0.0, 4.8e-3, 9.5e-3, 14e-3]), np.array([0.0, 0.0, 1.4e-6, 3e-6]), np.array([2e-6, 1.2e-6, 0.0, 0.0])
)
PUMP = Pump(2.8e-3, 3e7, 3e5)


def made(n, rows=2000, seed=1):
    rng = np.random.default_rng(seed)
    travel, p_in = rng.uniform(0.0, 14e-3, (rows, 1, n)), rng.uniform(1e6, 2e7, (rows, 1, n))
    q = flows_of(CircuitModel((TRUE,) * n, PUMP), travel[:, 0], p_in[:, 0])
    noise = (np.full(n, 5e-6), np.full(n, 1e5), np.full(n, 8e-6))
    return CircuitRows(
        travel + rng.normal(0.0, noise[0][0], travel.shape),
        p_in + rng.normal(0.0, noise[1][0], p_in.shape),
        np.zeros_like(p_in),
        q + rng.normal(0.0, noise[2][0], q.shape),
        np.zeros((*q.shape, 2)),
        np.ones(q.shape, dtype=bool),
        np.arange(rows) * 20 // rows,
        *noise,
        np.zeros(n),
    )


@pytest.mark.parametrize("n", [1, 2])
def test_curves_pump_and_missing_knots_are_found(n):
    rows = made(n)
    start = CircuitModel((START,) * n, PUMP._replace(flow=3.0e-3))
    prior = Prior(start, 1.0, {"flow": 3e-4})
    hold = rows.block % 5 == 4
    grown = grow(start, rows.some(~hold), rows.some(hold), prior, 16)
    model, _ = fit_circuit(grown.model, rows, prior, 6)
    assert model.pump.flow == pytest.approx(PUMP.flow, rel=1e-3)
    at = np.linspace(5.2e-3, 9.2e-3, 30)
    for found in model.valves:
        assert np.allclose(
            np.interp(at, found.knots, found.inlet), np.interp(at, TRUE.knots, TRUE.inlet), rtol=0.05, atol=8e-9
        )
        assert np.allclose(
            np.interp(at, found.knots, found.bypass), np.interp(at, TRUE.knots, TRUE.bypass), rtol=0.05, atol=8e-9
        )
        assert np.all(np.diff(found.inlet) >= 0.0)
        assert np.all(np.diff(found.bypass) <= 0.0)
        assert np.all(np.diff(found.knots) > 0.0)
        assert len(found.knots) <= 8
    off = flows_of(model, rows.travel[:, 0], rows.p_in[:, 0]) - rows.q_in
    assert np.sqrt(np.mean(off**2)) < 0.01 * PUMP.flow
    errors = circuit_errors(model, rows, prior)
    assert abs(model.pump.flow - PUMP.flow) < 5.0 * errors.pump["flow"]
    assert grown.held_out < 0.2 * grown.path[0][1]  # the start cannot follow


def test_curves_that_are_all_too_narrow_are_left_for_those_of_the_rows():
    rows = made(1)
    narrow = START._replace(inlet=0.4 * START.inlet, bypass=0.4 * START.bypass)
    start = CircuitModel((narrow,), PUMP)
    prior = Prior(start, 1.0, {"flow": 3e-4, "lead": 0.02})
    hold = rows.block % 5 == 4
    grown = grow(start, rows.some(~hold), rows.some(hold), prior, 16)
    assert grown.held_out < 0.6


def test_gradients_are_those_of_differences():
    rows = made(2, 300)
    start = CircuitModel((START, TRUE), PUMP)
    prior = Prior(start, 1.0, {"flow": 3e-4, "lead": 0.02, "lead_position": 0.02})
    rng = np.random.default_rng(2)
    rows = rows._replace(
        p_rate=rng.normal(0.0, 1e6, rows.p_rate.shape), q_rates=rng.normal(0.0, 1e-2, rows.q_rates.shape)
    )
    # weights move with the model, which steps leave out: noise of flows alone keeps them
    rows = rows._replace(noise_travel=np.zeros(2), noise_pressure=np.zeros(2), noise_flow=np.full(2, 3e-3))
    at = normal(start, rows, prior)
    step = 1e-10
    up, down = (
        normal(
            start._replace(valves=(START._replace(inlet=START.inlet + sign * step * np.eye(4)[2]), TRUE)), rows, prior
        ).loss
        for sign in (1.0, -1.0)
    )
    assert (up - down) / (2.0 * step) == pytest.approx(at.gradient[2], rel=1e-4)
    step = 1e-6
    for place, name in ((-2, "lead"), (-1, "lead_position")):
        up, down = (normal(start._replace(**{name: sign * step}), rows, prior).loss for sign in (1.0, -1.0))
        assert (up - down) / (2.0 * step) == pytest.approx(at.gradient[place], rel=1e-3)


def test_sensors_of_pressure_that_are_late_are_found():
    rows = made(1, 2000)
    rate = np.random.default_rng(5).normal(0.0, 3e7, rows.p_rate.shape)
    late = rows._replace(p_in=rows.p_in - 0.005 * rate, p_rate=rate)
    start = CircuitModel((TRUE,), PUMP)
    model, _ = fit_circuit(start, late, Prior(start, 1.0, {"flow": 3e-4, "lead": 0.02}), 10)
    assert model.lead == pytest.approx(0.005, abs=1.5e-3)


def test_a_knot_at_which_no_curve_bends_is_known_to_lie_within_the_travel():
    flat = Curves(np.insert(TRUE.knots, 1, 2e-3), np.insert(TRUE.inlet, 1, 0.0), np.insert(TRUE.bypass, 1, 0.0))
    flat.bypass[:3] = TRUE.bypass[1]
    rows = made(1, 1000)
    errors = circuit_errors(CircuitModel((flat,), PUMP), rows, Prior(CircuitModel((flat,), PUMP), 1.0, {})).valves[0]
    assert 0.0 < errors["knots"][1] <= 1.01 * TRUE.knots[-1]
    assert errors["knots"][3] < 1e-4  # where the curves bend
    assert all(np.isfinite(e).all() and e[1] < 1e-5 for key, e in errors.items() if key != "knots")


def test_sensors_of_position_that_are_late_are_found():
    rows = made(1, 2000)
    rates = np.random.default_rng(6).normal(0.0, 5e-3, rows.q_rates.shape)
    late = rows._replace(q_in=rows.q_in - rates @ (0.0, -0.0075), q_rates=rates)
    start = CircuitModel((TRUE,), PUMP)
    model, _ = fit_circuit(start, late, Prior(start, 1.0, {"flow": 3e-4, "lead_position": 0.02}), 10)
    assert model.lead_position == pytest.approx(-0.0075, abs=2e-4)
    assert np.abs(measured_flows(model, late) - rows.q_in).max() < 1e-5


def test_what_no_row_shows_stays_near_its_value():
    rows = made(1)
    seen = rows.some(rows.travel[:, 0, 0] < 8e-3)
    start = CircuitModel((START,), PUMP)
    prior = Prior(start, 1.0, {})
    model, _ = fit_circuit(start, seen, prior, 10)
    assert model.valves[0].inlet[-1] == pytest.approx(START.inlet[-1], rel=0.25)


def test_an_orifice_that_steps_shut_is_shut_and_not_open_by_what_rounding_leaves():
    valve = Curves(np.array([0.0, 5e-3, 9e-3]), np.array([0.0, 1e-6, 2e-6]), np.array([3e-6, 1e-6, 1e-6]))
    step = np.concatenate([np.zeros(3), -(1.0 - 1e-15) * np.array([0.0, 1e-6, 1e-6]), np.zeros(3)])
    found = moved(CircuitModel((valve,), PUMP), step, []).valves[0]
    assert found.bypass.tolist() == [3e-6, 0.0, 0.0]
    assert found.inlet.tolist() == valve.inlet.tolist()
