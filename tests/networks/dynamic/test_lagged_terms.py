import numpy as np
import pytest

from polydraulic.networks.dynamic.lagged_terms import Terms, averaged, frame_of, run_terms

READS = [(0, 1), (1, 1), (2, 1), (2, 2)]  # one input, two outputs
TERMS = Terms(
    np.array([[0, 0, 0], [2, 0, 0], [1, 1, 0], [4, 3, 0], [3, 0, 0], [3, 2, 1]], dtype=np.int64),
    np.array([0, 0, 0, 1, 1, 1], dtype=np.int64),
    np.array([0.1, 0.7, 0.2, 0.15, 0.6, -0.3]),
)


def frame(n=40, margin=0.5):
    signals = np.random.default_rng(3).normal(size=(n, 3))
    return frame_of(signals, 2, READS, [(2, n)], margin)


def errors_and_slopes(frame, terms, windows, **options):
    parts = list(run_terms(frame, terms, windows, **options))
    return np.concatenate([one for one, _ in parts]), np.concatenate([one for _, one in parts])


def test_slopes_are_those_of_whole_runs():
    one, windows = frame(), [(2, 12), (12, 30), (30, 40)]
    errors, slopes = errors_and_slopes(one, TERMS, windows)
    for p in range(len(TERMS.coef)):
        ends = []
        for sign in (1.0, -1.0):
            coef = TERMS.coef.copy()
            coef[p] += sign * 1e-6
            ends.append(errors_and_slopes(one, TERMS._replace(coef=coef), windows)[0])
        assert np.allclose((ends[0] - ends[1]) / 2e-6, slopes[:, p], rtol=1e-5, atol=1e-6)
    assert np.abs(slopes).max(axis=0).min() > 0.1
    (values, none), *_ = run_terms(one, TERMS, windows, slopes=False)
    assert np.array_equal(values, errors)
    assert none.shape == (76, 0)


def test_a_window_begins_from_what_was_measured():
    one = frame()
    whole, _ = errors_and_slopes(one, TERMS, [(2, 12), (12, 20)])
    alone, _ = errors_and_slopes(one, TERMS, [(12, 20)])
    assert np.array_equal(whole[20:], alone)


def test_windows_that_do_not_fit_into_memory_together_give_the_same():
    one, windows = frame(), [(2, 12), (12, 30), (30, 40)]
    whole = errors_and_slopes(one, TERMS, windows)
    assert len(list(run_terms(one, TERMS, windows, batch=1))) == 3
    parts = errors_and_slopes(one, TERMS, windows, batch=1)
    assert all(np.array_equal(a, b) for a, b in zip(parts, whole, strict=True))


def test_answers_stay_in_their_range_and_have_no_slope_there():
    one = frame(margin=0.0)
    errors, slopes = errors_and_slopes(one, TERMS._replace(coef=50.0 * TERMS.coef), [(2, 40)])
    answers = errors.reshape(-1, 2) + one.signals[2:, 1:]
    bounded = np.isclose(answers, one.y_low, atol=1e-12) | np.isclose(answers, one.y_high, atol=1e-12)
    assert bounded.mean() > 0.5
    assert not slopes[bounded.ravel()].any()
    assert np.all((answers > one.y_low - 1e-12) & (answers < one.y_high + 1e-12))


def test_the_average_of_polynomials_is_one():
    other = Terms(np.array([[2, 0, 0], [1, 0, 0]]), np.array([0, 1]), np.array([1.0, 4.0]))
    found = averaged([TERMS, other], np.array([3.0, 1.0]))
    value = {(k, *f): c for k, f, c in zip(found.output, found.factors.tolist(), found.coef, strict=True)}
    assert value[0, 2, 0, 0] == pytest.approx(0.75 * 0.7 + 0.25)
    assert value[1, 1, 0, 0] == pytest.approx(1.0)
    assert value[1, 3, 2, 1] == pytest.approx(-0.225)
    assert len(value) == 7
