import numpy as np
import pytest

from polydraulic.measure.checks.run_lengths import ValueRuns


def kinds(value, parts=1):
    runs = ValueRuns()
    rows = np.arange(len(value)) + 1
    for v, r in zip(np.array_split(value, parts), np.array_split(rows, parts), strict=True):
        runs.add(v, r)
    return {kind: [(run.first, run.last) for run in found] for kind, found, _ in runs.findings()}


def noisy(n=4000, seed=0):
    rng = np.random.default_rng(seed)
    return 10.0 * np.sin(np.arange(n) / 100.0) + rng.normal(0.0, 0.1, n)


@pytest.mark.parametrize("parts", [1, 7, 500])
def test_runs_are_the_same_in_any_blocks(parts):
    value = noisy()
    value[1000:1200] = value[1000]
    value[2000:2100] = 3.0
    assert kinds(value, parts) == {"frozen": [(1001, 1200), (2001, 2100)]}
    assert kinds(np.minimum(noisy(), 8.0), parts).keys() == {"clipped"}


def test_what_an_operator_does_is_no_fault():
    lever = np.repeat([0.0, 0.8, 0.0, -0.8, 0.3, 0.0], [100, 300, 50, 200, 400, 150])
    assert kinds(np.convolve(lever, np.full(20, 0.05), mode="valid")) == {}  # without noise, held
    assert kinds(lever + 0.001 * np.random.default_rng(0).integers(-3, 4, len(lever))) == {}  # few values, fine digits
    rest = np.concatenate([np.zeros(500), noisy(3770), np.zeros(500)])
    assert kinds(rest) == {}  # at rest where the signal passes through 0


def test_few_values_far_apart_are_coarse():
    assert kinds(4.0 * np.round(noisy() / 4.0)).keys() >= {"coarse"}
