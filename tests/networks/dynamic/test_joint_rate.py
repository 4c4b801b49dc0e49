import numpy as np
import pytest

from polydraulic.networks.dynamic.joint_rate import Factors, learn_rate
from polydraulic.networks.dynamic.lagged_terms import frame_of

N = 3000
SPANS = [(1, 1400), (1420, N)]


def joint(*, slow=slice(0, 0), stop=np.inf, weak=False):
    """An opening to either side, what others take, an angle that matters, one that does not, and the joint."""
    rng = np.random.default_rng(1)
    push = np.repeat(rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], size=N // 20), 20)
    demand = np.repeat(rng.choice([0.0, 0.0, 1.0], size=N // 30), 30)
    if weak:  # other valves move on the weaker day alone
        demand[SPANS[0][1] :] = 0.0
    other, idle = np.cumsum(rng.normal(scale=0.05, size=(2, N)), axis=1)
    other /= np.abs(other).max()
    idle /= np.abs(idle).max()
    y = np.zeros(N)
    for t in range(1, N):
        rate = 0.02 * max(push[t], 0.0) - 0.021 * max(-push[t], 0.0)
        rate *= 1.0 - 0.2 * demand[t] - 0.1 * y[t - 1] + 0.15 * other[t - 1]
        rate *= 0.7 if weak and t < SPANS[0][1] else 1.0
        rate *= 0.4 if slow.start <= t < slow.stop else 1.0
        y[t] = min(y[t - 1] + rate, stop)
    y_noisy = y + rng.normal(scale=1e-3, size=N)
    return np.column_stack([np.maximum(push, 0.0), np.maximum(-push, 0.0), demand, other, idle, y_noisy])


def learnt(signals, *, away=None, most=5, known=(2, 5), offered=(3, 4)):
    frame = frame_of(signals, 1, [(c, int(c > 2)) for c in range(6)], SPANS, 0.02, n_raw=3)
    away = np.ones(N, dtype=bool) if away is None else away
    terms, error, _ = learn_rate(frame, Factors((0, 1), known, offered), SPANS, away, 16, 200, 4, most)
    coef = {tuple(one): float(c) for one, c in zip(terms.factors.tolist(), terms.coef, strict=True)}
    return frame, coef, error


def test_gains_and_what_changes_them_are_found():
    frame, coef, error = learnt(joint())
    assert set(coef) == {(6, 0, 0)} | {(max(a, b), min(a, b), 0) for a in (0, 3, 4, 6) for b in (1, 2)}
    assert coef[6, 0, 0] == 1.0
    scale, mean = frame.scale[-1], frame.mean
    at_middle = 1.0 - 0.1 * mean[5] + 0.15 * mean[3]
    assert coef[1, 0, 0] * scale == pytest.approx(0.02 * at_middle, rel=0.03)
    assert coef[2, 0, 0] * scale == pytest.approx(-0.021 * at_middle, rel=0.03)
    assert coef[3, 1, 0] * scale == pytest.approx(-0.2 * 0.02, rel=0.05)
    assert coef[4, 2, 0] * scale / frame.scale[3] == pytest.approx(-0.15 * 0.021, rel=0.05)
    assert error < 0.05


def test_what_gains_nothing_is_left_out_and_no_more_is_taken_than_may_be():
    _, coef, _ = learnt(joint())
    assert not any(5 in one for one in coef)
    _, none, error = learnt(joint(), most=0)
    assert not any({4, 5} & set(one) for one in none)
    assert error > learnt(joint())[2]


def gain_as_share_of_truth(signals, **options):
    frame, coef, _ = learnt(signals, **options)
    return coef[1, 0, 0] * frame.scale[-1] / (0.02 * (1.0 - 0.1 * frame.mean[5] + 0.15 * frame.mean[3]))


def test_a_stretch_of_hard_work_hardly_moves_the_gains():
    assert gain_as_share_of_truth(joint()) == pytest.approx(1.0, abs=0.01)
    # at 0.4 of the speed for an eighth of the rows: squares would make 0.949
    assert gain_as_share_of_truth(joint(slow=slice(500, 875))) == pytest.approx(1.0, abs=0.04)


def test_rows_at_a_stop_say_nothing_of_the_gains():
    signals = joint(stop=0.3)
    assert (signals[:, 5] > 0.25).mean() > 0.1
    assert gain_as_share_of_truth(signals, away=signals[:, 5] < 0.25) == pytest.approx(1.0, abs=0.03)
    assert gain_as_share_of_truth(signals) < 0.95


def test_a_weaker_day_does_not_smear_what_changes_the_rate():
    frame, coef, _ = learnt(joint(weak=True), most=0)
    share = -0.2 / (1.0 - 0.1 * frame.mean[5] + 0.15 * frame.mean[3])  # it would be -0.39 if all days counted as one
    assert coef[3, 1, 0] / coef[1, 0, 0] == pytest.approx(share, abs=0.03)
    assert coef[3, 2, 0] / coef[2, 0, 0] == pytest.approx(share, abs=0.03)
