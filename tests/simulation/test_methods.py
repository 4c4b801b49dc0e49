"""Methods of `simulate`: the order of each, and that all give the same run."""

import numpy as np
import pytest

from helpers.smooth_run import (
    SMOOTH,
    VOLTS,
    joint_errors,
)
from polydraulic import load_scenario, simulate
from polydraulic.errors import InputError
from polydraulic.parameters.scenario import scenario_names
from polydraulic.simulation.runs import METHODS
from polydraulic.thesis.excavator import pump_of

# of this layout; `tests/machines` has the methods of another one compiled
EACH = [pytest.param(m, marks=[] if m == "semi-implicit" else pytest.mark.slow_to_compile) for m in METHODS]


@pytest.fixture(scope="module")
def tight(machine):
    """Tight solution of a scenario by its name."""
    found = {}

    def solution(name):
        if name not in found:
            found[name] = simulate(machine, "exact", load_scenario(name), method="reference", rtol=1e-9)
        return found[name]

    return solution


# Largest joint errors in degrees at 5 ms, swing, boom, stick, with what a scenario's events leave of the order.
LOOP = {
    "single_05": (0.0, 0.03, 0.0),
    "single_08": (0.0, 0.1, 0.0),
    "sine": (0.08, 0.09, 0.02),
    "step": (0.25, 0.06, 0.15),
    "pulse": (0.6, 0.2, 0.15),
    "task": (0.15, 0.05, 0.1),
}
RUNGE_KUTTA = {
    "single_05": (0.0, 1e-3, 0.0),
    "single_08": (0.0, 1e-3, 0.0),
    "sine": (1e-3, 1e-3, 1e-3),
    "step": (0.01, 0.01, 0.01),
    "pulse": (0.1, 0.2, 0.05),
    "task": (1e-3, 1e-3, 1e-3),
}


@pytest.mark.slow
@pytest.mark.parametrize(("method", "limits"), [("semi-implicit", LOOP), ("rk4", RUNGE_KUTTA)])
def test_fixed_steps_stay_near_the_tight_solution(machine, tight, method, limits):
    for name, limit in limits.items():
        found = simulate(machine, "exact", load_scenario(name), method=method)
        assert np.all(joint_errors(found, tight(name)) <= limit), name


@pytest.mark.slow
@pytest.mark.parametrize("name", scenario_names("cat215b"))
def test_the_rosenbrock_method_keeps_its_tolerance(machine, tight, name):
    """Joints within a hundred tolerances in radians, whatever happens on the way, and the same events at the same times."""
    for rtol in (1e-3, 1e-5, 1e-7):
        found = simulate(machine, "exact", load_scenario(name), method="rosenbrock", rtol=rtol)
        assert np.all(joint_errors(found, tight(name)) <= np.degrees(100.0 * rtol)), rtol
        ours, theirs = found.info["events"], tight(name).info["events"]
        assert [event[1:] for event in ours] == [event[1:] for event in theirs] or rtol == 1e-3
    assert [event[0] for event in ours] == pytest.approx([event[0] for event in theirs], abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", scenario_names("cat215b"))
def test_methods_agree_on_when_things_happen(machine, tight, name):
    """Spool edges within a step where voltages are held over it, and to a tenth of one where not; stops within 50 ms."""
    theirs = tight(name).info["events"]
    for method, spools in (("semi-implicit", 5e-3), ("rk4", 5e-4)):
        ours = simulate(machine, "exact", load_scenario(name), method=method).info["events"]
        for time, link, what in theirs:
            times = [event[0] for event in ours if event[1:] == [link, what]]
            limit = spools if "valve" in what or "bypass" in what else (0.05 if "stop" in what else np.inf)
            assert limit == np.inf or min(abs(t - time) for t in times) < limit, (method, link, what)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "euler"}, r"unknown method 'euler'; choose one of \['semi-implicit', 'rk4'"),
        ({"method": "rk4", "rtol": 1e-6}, "rtol = 1e-06 with method 'rk4': goes with"),
        ({"method": "reference", "rtol": 0.0}, "rtol = 0.0"),
        ({"method": "reference", "rtol": "1e-9"}, "rtol = 1e-9 with method 'reference': goes with .*, a number from"),
        ({"method": "reference", "rtol": float("nan")}, "rtol = nan"),
    ],
)
def test_bad_settings_are_named(machine, options, message):
    with pytest.raises(InputError, match=message):
        simulate(machine, "exact", SMOOTH, **options)


@pytest.mark.parametrize("method", EACH)
def test_every_method_gives_the_same_columns(machine, method):
    found = simulate(machine, "exact", SMOOTH, t_end=0.1, dt=0.01, method=method)
    assert found.names == simulate(machine, "exact", SMOOTH, t_end=0.1, dt=0.01).names
    assert found.info["method"] == method
    assert len(found) == 11
    assert found["swing.spool"][-1] == pytest.approx(VOLTS[0] * 0.01397 * (1 - np.exp(-0.1 / 0.205)), rel=1e-6)


@pytest.mark.parametrize("method", EACH)
def test_a_run_of_one_row_is_its_start(machine, method):
    found = simulate(machine, "exact", SMOOTH, t_end=0.01, dt=0.01, every=2, method=method)
    assert len(found) == 1
    assert found["swing.angle"][0] == machine.function("swing").initial.angle
    assert found["boom.q_pump"][0] == pytest.approx(pump_of(machine, "boom").flow)


@pytest.mark.slow_to_compile
def test_runge_kutta_is_the_limit_of_short_steps_with_networks(machine):
    """Of first order the steps of the default, far closer those of the other, on the circuits that networks take the place of."""

    def run(method, dt):
        return simulate(machine, "polynomial", SMOOTH, method=method, dt=dt, raster=8e-3, t_end=0.48)

    def off(found):
        return max(np.abs(found[f"{f}.angle"] - tight[f"{f}.angle"]).max() for f in machine.names)

    tight, coarse, fine, rk4 = (
        run("rk4", 1e-3),
        run("semi-implicit", 4e-3),
        run("semi-implicit", 1e-3),
        run("rk4", 4e-3),
    )
    assert 3.0 < off(coarse) / off(fine) < 5.5
    assert off(rk4) < 0.2 * off(fine)
    assert tight.info["steps_out_of_domain"] == 0
    truth = simulate(machine, "polynomial", SMOOTH, method="reference", rtol=1e-9, dt=8e-3, t_end=0.48)
    assert off(truth) < 0.01 * off(fine)
    assert truth.info["rows_out_of_domain"] == 0
    with pytest.raises(
        InputError, match="does not integrate it; use method 'semi-implicit' or 'rk4' or 'reference', or flow 'exact'"
    ):
        simulate(machine, "polynomial", SMOOTH, method="rosenbrock")
