import numpy as np
import pytest

from polydraulic.measure.checks.run_lengths import ValueRuns


def kinds(value, parts=1):
    runs = ValueRuns()
    rows = np.arange(len(value)) + 1
    for v, r in zip(np.array_split(value, parts), np.array_split(rows, parts), strict=True):
        runs.add(v, r)
    found = {kind: [(run.first, run.last) for run in spans] for kind, spans, _ in runs.findings()}
    assert parts != 1 or found == kinds(value, 7)  # whatever the blocks
    return found


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


def scattered(n=2000):
    """Noise between 1 and 10, which it reaches."""
    value = np.random.default_rng(1).uniform(1.0, 9.9, n)
    value[5] = 10.0
    return value


@pytest.mark.parametrize(("n", "found"), [(49, False), (50, True)])
def test_a_noisy_signal_is_frozen_from_fifty_equal_samples_on(n, found):
    value = scattered()
    value[1000 : 1000 + n] = 5.0
    assert kinds(value) == ({"frozen": [(1001, 1000 + n)]} if found else {})


@pytest.mark.parametrize(("times", "found"), [(3, True), (4, False)])
def test_what_is_held_again_and_again_is_not_frozen(times, found):
    value = scattered()
    for start in range(100, 100 + 400 * times, 400):
        value[start : start + 60] = value[start]
    assert len(kinds(value).get("frozen", [])) == (3 if found else 0)


@pytest.mark.parametrize(("back", "found"), [(7, False), (8, True)])
def test_a_signal_with_noise_turns_round_at_a_seventh_of_its_samples(back, found):
    """Of a hundred steps so many go back, each with a turn before and after it."""
    step = np.where((np.arange(4000) % 100 < 2 * back) & (np.arange(4000) % 2 == 0), -1.0, 1.3)
    value = np.cumsum(step)
    value = np.concatenate([value[:2000], np.full(60, value[2000]), value[2001:]])
    assert ("frozen" in kinds(value)) == found


@pytest.mark.parametrize(("before", "found"), [(1.9, False), (2.1, True)])
def test_a_lost_signal_falls_to_0_by_a_fifth_of_its_range(before, found):
    value = scattered()
    value[999], value[1000:1060] = before, 0.0
    assert ("frozen" in kinds(value)) == found


@pytest.mark.parametrize(("n", "found"), [(9, True), (10, False)])
def test_a_signal_that_rests_at_0_elsewhere_rests(n, found):
    value = scattered()
    value[999], value[1000:1060] = 9.0, 0.0
    value[499], value[500 : 500 + n] = 1.5, 0.0
    assert ("frozen" in kinds(value)) == found


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("lengths", "elsewhere", "found"),
    [
        ([10, 10], [], True),
        ([10, 9], [], False),  # twenty samples
        ([20], [], False),  # in two runs
        ([5, 5, 5, 5], [], True),
        ([4, 4, 4, 4, 4, 4], [], False),  # of five
        ([10, 10], [13, 13, 13], True),
        ([10, 10], [13, 13, 14], False),  # and elsewhere fewer than a fiftieth
        ([10, 10], [4] * 10, True),
    ],
)
def test_a_signal_is_clipped_when_its_end_is_held_again_and_again(side, lengths, elsewhere, found):
    value, at = scattered(), 50
    for n, level in [*((n, 10.0) for n in lengths), *((n, 2.0 + 0.1 * i) for i, n in enumerate(elsewhere))]:
        value[at : at + n] = level
        at += n + 50
    assert ("clipped" in kinds(side * value)) == found


def test_what_is_clipped_is_not_frozen_and_0_is_no_end():
    value = scattered()
    value[100:160] = value[300:310] = 10.0
    assert kinds(value) == {"clipped": [(101, 160), (301, 310)]}
    assert "clipped" not in kinds(value - 10.0)


@pytest.mark.parametrize(
    ("levels", "repeat", "found"),
    [
        (np.arange(20.0), 3, True),
        (np.arange(21.0), 3, False),  # twenty values
        (np.arange(20.0), 2, False),  # held
        (np.array([0.0, 0.95, 18.0, 19.0]), 3, False),  # a twentieth of the range apart
        (np.array([0.0, 0.95, 17.0, 18.0]), 3, True),
    ],
)
def test_a_coarse_signal_has_few_values_far_apart_and_holds_them(levels, repeat, found):
    chosen = np.random.default_rng(0).integers(1, len(levels), 500)
    place = np.concatenate([np.arange(len(levels)), np.cumsum(chosen) % len(levels)])
    place = place[np.concatenate([[True], np.diff(place) != 0])]
    assert ("coarse" in kinds(np.repeat(levels[place], repeat))) == found


@pytest.mark.parametrize(
    ("held", "n", "at", "found"),
    [
        (201, 11, 5, True),
        (200, 11, 5, False),  # twenty times the usual hold
        (300, 10, 5, False),  # of more than ten
        (300, 11, 11, False),  # at an end
        (300, 11, 0, False),
    ],
)
def test_a_signal_without_noise_is_frozen_where_it_is_held_far_longer(held, n, at, found):
    level = 1.0 + np.arange(n + 1 if n == 11 else n) ** 2
    lengths = np.full(len(level), 10)
    lengths[at] = held
    first = 10 * at + 1
    assert kinds(np.repeat(level, lengths)) == ({"frozen": [(first, first + held - 1)]} if found else {})
    assert kinds(np.repeat(level - level[at], lengths)) == {}  # 0 is rest
