import numpy as np
import pytest

from polydraulic import InputError, load_scenario
from polydraulic.simulation.steps import n_steps, recorded_steps


def test_whole_steps_of_a_duration_that_rounding_leaves_short():
    assert n_steps(load_scenario("random:1:0.3"), 0.1, None) == 3
    assert recorded_steps(0.005, 1, 0.1) == 20


@pytest.mark.parametrize(
    ("t_end", "every", "words"),
    [(0.001, 1, "at least one time step"), (float("nan"), 1, "finite"), (1.0, 0, "every = 0")],
)
def test_runs_without_steps_are_refused(t_end, every, words):
    with pytest.raises(InputError, match=words):
        n_steps(load_scenario("random:1:5"), 0.005, t_end, every)


@pytest.mark.parametrize("dt", [0.0, -0.005, float("nan"), float("inf")])
def test_a_step_must_be_a_positive_time(dt):
    with pytest.raises(InputError, match="time step must be positive"):
        n_steps(load_scenario("random:1:5"), dt, None)


def test_a_raster_must_be_whole_steps_and_not_given_twice():
    with pytest.raises(InputError, match="whole number of time steps"):
        recorded_steps(0.005, 1, 0.007)
    with pytest.raises(InputError, match="give one of them"):
        recorded_steps(0.005, 2, 0.01)


@pytest.mark.parametrize("text", ["10 ms", None, True, [1.0]])
def test_times_are_numbers(text):
    for call, what in (
        (lambda: n_steps(load_scenario("random:1:5"), text, None), "dt"),
        (lambda: recorded_steps(text, 1, 0.01), "dt"),
        (lambda: recorded_steps(0.005, 1, text if text is not None else "none"), "raster"),
        (lambda: n_steps(load_scenario("random:1:5"), 0.005, text if text is not None else "none"), "duration"),
    ):
        with pytest.raises(InputError, match=f"{what} = .*: must be a number, in s"):
            call()
    assert recorded_steps(np.float64(0.005), 1, np.int64(1)) == 200
