import numpy as np
import pytest

from helpers.smooth_run import (
    SMOOTH,
    end_by_rosenbrock,
    end_by_runge_kutta,
    joint_errors,
    smooth_start,
)
from polydraulic import random_operator, simulate
from polydraulic.errors import InputError
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import LINKS
from polydraulic.parameters.signals import Piecewise


def test_the_rosenbrock_method_is_of_fourth_order_in_its_steps(machine):
    moving = smooth_start(machine)
    truth = end_by_rosenbrock(machine, moving, 1e-11)[0]
    assert truth == pytest.approx(end_by_runge_kutta(machine, moving, 160), rel=1e-6)
    ends = [end_by_rosenbrock(machine, moving, rtol) for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)]
    errors = [np.abs(end - truth)[9:].max() for end, _ in ends]
    steps = [n for _, n in ends]
    assert 3.5 < -np.polyfit(np.log(steps), np.log(errors), 1)[0] < 4.6
    assert all(error < 10.0 * rtol for error, rtol in zip(errors, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8), strict=True))


@pytest.mark.parametrize("limited", [False, True])
def test_bounds_hold_under_a_random_operator(machine, limited):
    """No pressure leaves its bounds and no joint its stops, whatever the voltages; with torque limit as without."""
    rng = np.random.default_rng(5)
    times = np.arange(0.0, 4.0, 0.4)
    machine = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=limited))
    wild = Scenario("wild", 4.0, {link: Piecewise(times, rng.uniform(-1.1, 1.1, times.size)) for link in LINKS})
    found = simulate(machine, "exact", wild, method="rosenbrock", dt=0.01, rtol=1e-3)
    for link in LINKS:
        parts = getattr(machine, link)
        for port in ("p_a", "p_b"):
            assert found[f"{link}.{port}"].min() >= machine.tank.floor
            assert found[f"{link}.{port}"].max() <= parts.line.relief
        assert found[f"{link}.angle"].min() >= parts.stops.low - 1e-9
        assert found[f"{link}.angle"].max() <= parts.stops.high + 1e-9
    closer = simulate(machine, "exact", wild, method="rosenbrock", dt=0.01, rtol=1e-5)
    assert np.all(joint_errors(found, closer) < 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("limited", [False, True])
def test_ten_minutes_of_a_random_operator(machine, limited):
    """Boom and stick lean against their stops together, over and over: no more than three events a second, and it converges."""
    machine = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=limited))
    coarse, fine = (
        simulate(machine, "exact", random_operator(5, 600.0), method="rosenbrock", rtol=rtol, dt=0.05)
        for rtol in (1e-3, 1e-5)
    )
    assert fine.info["events_located"] < 1800
    assert fine.info["events_dropped"] == 0
    assert np.all(joint_errors(coarse, fine) < 0.1)


def test_the_rosenbrock_method_needs_slopes(machine):
    with pytest.raises(InputError, match=r"needs the slopes of the flows, which flow 'iterative' does not give"):
        simulate(machine, "iterative", SMOOTH, method="rosenbrock")
