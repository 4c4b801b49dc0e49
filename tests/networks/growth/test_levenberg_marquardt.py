import numpy as np
import pytest

from polydraulic.networks.growth.levenberg_marquardt import Damping, Equations, lower_loss

T = np.linspace(0.0, 4.0, 40)
TRUE = np.array([2.0, 0.7])
RULES = Damping(largest=1e12, raise_by=4.0, lower=lambda share: 0.2, least_relative=1e-12, enough=1e-9)


def decay(coef):
    return coef[0] * np.exp(-coef[1] * T)


def evaluate(coef, limit):
    with np.errstate(over="ignore", invalid="ignore"):
        error = decay(coef) - decay(TRUE)
        loss = float(error @ error)
    if not loss < limit:
        return None
    slope = np.column_stack([np.exp(-coef[1] * T), -coef[0] * T * np.exp(-coef[1] * T)])
    return Equations(slope.T @ slope, slope.T @ error, loss, loss)


def lowered(start, rules=RULES, **limits):
    losses = []
    coef, there = lower_loss(
        start, evaluate(start, np.inf), evaluate, rules, watch=lambda attempt, loss: losses.append(loss), **limits
    )
    return coef, there, losses


def test_a_curve_is_found_and_the_loss_never_rises():
    start = np.array([0.5, 3.0])
    coef, there, losses = lowered(start)
    assert coef == pytest.approx(TRUE, rel=1e-5)
    assert there.loss == losses[-1] < 1e-9
    assert losses == sorted(losses, reverse=True)
    assert len(losses) > 3


def test_limits_of_attempts_and_steps_hold():
    start = np.array([0.5, 3.0])
    assert lowered(start, max_attempts=0)[0] is start
    assert len(lowered(start, max_steps=2)[2]) == 2
    assert len(lowered(start, max_attempts=2)[2]) <= 2


def test_nothing_moves_at_the_minimum():
    coef, there, losses = lowered(TRUE)
    assert coef is TRUE
    assert (there.loss, losses) == (0.0, [])


def test_damping_that_grows_too_large_ends_the_search():
    calls = []

    def never(coef, limit):
        calls.append(coef)

    start = np.array([0.5, 3.0])
    coef, _ = lower_loss(start, evaluate(start, np.inf), never, RULES._replace(largest=1.0))
    assert coef is start
    assert len(calls) == 5  # 0.001 * 4**5 is more than 1
    assert np.linalg.norm(calls[-1] - start) < np.linalg.norm(calls[0] - start)


def test_slopes_without_bound_end_the_search_where_it_is():
    start = np.array([0.5, 3.0])
    here = evaluate(start, np.inf)
    coef, there = lower_loss(start, here, lambda coef, limit: here._replace(gram=here.gram * np.inf, loss=0.0), RULES)
    assert coef is start
    assert there is here


def test_the_last_of_several_slow_steps_is_counted():
    start = np.array([0.5, 3.0])
    patient = RULES._replace(enough=2.0, last_steps=3)  # every step is slow
    assert len(lowered(start, patient)[2]) == 3
