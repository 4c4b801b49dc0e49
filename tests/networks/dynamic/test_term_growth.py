import numpy as np

from polydraulic.networks.dynamic.lagged_terms import frame_of, run_terms
from polydraulic.networks.dynamic.term_growth import grow_average, grow_terms

READS = [(0, 1), (0, 2), (1, 1), (1, 2)]
TRUE = {(0, 0, 0), (3, 0, 0), (4, 0, 0), (2, 0, 0), (2, 2, 0)}


def noisy(n=300, noise=0.02):
    rng = np.random.default_rng(5)
    u, y = np.repeat(rng.uniform(-1.0, 1.0, size=n // 5), 5), np.zeros(n)
    for t in range(2, n):
        y[t] = 1.5 * y[t - 1] - 0.6 * y[t - 2] + 0.2 * u[t - 2] ** 2 + 0.1 * u[t - 2]
    return np.column_stack([u, y + rng.normal(scale=noise, size=n)]), y


def grown(signals, n_term, horizon=16, spans=None, **options):
    spans = [(2, len(signals))] if spans is None else spans
    frame = frame_of(signals, 1, READS, spans, 0.1)
    return frame, next(terms for terms in grow_terms(frame, spans, horizon, **options) if len(terms.coef) >= n_term)


def own(terms):
    return {tuple(one) for one in terms.factors.tolist()}


def free_run_error(frame, terms, truth):
    (errors, _), *_ = run_terms(frame, terms, [(2, len(truth))])
    answers = frame.mean[1] + frame.scale[1] * (errors + frame.signals[2:, 1])
    return float(np.sqrt(np.mean((answers - truth[2:]) ** 2)) / truth.std())


def test_terms_of_a_noisy_system_are_found_by_how_they_run():
    signals, truth = noisy()
    frame, terms = grown(signals, 5)
    assert own(terms) == TRUE
    assert free_run_error(frame, terms, truth) < 0.05
    # noise is taken for damping one step ahead
    assert free_run_error(*grown(signals, 5, horizon=1), truth) > 3.0 * free_run_error(frame, terms, truth)


def test_growth_ends_where_nothing_is_left_or_rows_are_few():
    signals, _ = noisy(noise=0.0)
    frame = frame_of(signals, 1, READS, [(2, 300)], 0.1)
    assert own(list(grow_terms(frame, [(2, 300)], 8))[-1]) >= TRUE
    assert len(list(grow_terms(frame, [(2, 300)], 8))) < 20
    assert len(list(grow_terms(frame, [(2, 22)], 8))[-1].coef) <= 4
    assert len(list(grow_terms(frame, [(2, 4)], 8))) == 1


def test_an_average_hangs_less_on_a_few_rows():
    signals, truth = noisy(150, noise=0.1)
    frame, one = grown(signals, 6)
    mean = grow_average(frame, [(2, 150)], 16, 6)
    assert len(mean.coef) >= 6
    assert free_run_error(frame, mean, truth) < free_run_error(frame, one, truth)


def test_what_never_changes_does_no_harm():
    signals, _ = noisy()
    signals[:, 0] = 4.0
    _, terms = grown(signals, 3)
    assert np.isfinite(terms.coef).all()
    signals[:, 1] = 1.0
    assert np.isfinite(grown(signals, 2)[1].coef).all()


def test_of_many_lagged_values_only_those_in_the_polynomial_are_multiplied():
    signals, _ = noisy()
    _, terms = grown(signals, 12, all_pairs=3)
    seen = set()
    for *factors, d in terms.factors.tolist():
        a, b = factors
        assert a == b or b == 0 or {a, b} & seen
        seen |= {a, b, d} - {0}
    assert any(a != b and b for a, b, _ in terms.factors.tolist())
