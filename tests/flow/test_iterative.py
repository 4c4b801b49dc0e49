import numba
import numpy as np
import pytest

from helpers.flow_steps import PSI, points, states, step, step_all
from polydraulic import build_flow, simulate
from polydraulic.errors import InputError
from polydraulic.flow import (
    NOT_CONVERGED,
    OK,
    iterative_flow,
)
from polydraulic.thesis.excavator import pump_of, spool_of


def test_iteration_settles_near_exact_in_series(machine):
    """Where it settles; the relaxation is small, since two pressures have to."""
    exact, model = build_flow("exact", machine), iterative_flow(machine, eps=1e-5, relaxation=0.05, max_sweeps=20000)
    full, settled = pump_of(machine, "series").flow, 0
    for spool, p_in, p_out in states(machine, 60):
        flows = step_all(machine, model, spool, p_in, p_out)
        if flows.status == OK:
            settled += 1
            true = step_all(machine, exact, spool, p_in, p_out)
            # p is known to eps / relaxation; where an inlet just opens, its flow is the root of that
            assert abs(flows.q_in.swing - true.q_in.swing) < 0.05 * full
            assert abs(flows.q_in.stick - true.q_in.stick) < 0.05 * full
    assert settled > 30


@pytest.mark.parametrize("eps", [0.1, 0.05, 0.001])
def test_iteration_approaches_exact_with_eps(machine, eps):
    exact, model = build_flow("exact", machine), iterative_flow(machine, eps=eps, max_sweeps=2000)
    errors = []
    for spool, p_in, p_out in points(machine):
        flows = step(machine, model, spool, p_in, p_out)
        if flows.status == OK:
            errors.append(
                abs(flows.q_in.boom - step(machine, exact, spool, p_in, p_out).q_in.boom)
                / pump_of(machine, "boom").flow
            )
    assert len(errors) > 150
    assert max(errors) < 1.2 * eps


def test_iteration_is_bounded_and_says_so(machine):
    plain = iterative_flow(machine, eps=0.001, relaxation=1.0, max_sweeps=50)
    spool = 0.9 * spool_of(machine).bypass_closed
    assert step(machine, plain, spool, 800 * PSI, 100 * PSI).status == NOT_CONVERGED
    relaxed = iterative_flow(machine, eps=0.001, relaxation=0.1, max_sweeps=500)
    assert step(machine, relaxed, spool, 800 * PSI, 100 * PSI).status == OK


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"eps": 0.0}, "eps = 0.0: must lie between 0 and 1"),
        ({"relaxation": 1.5}, r"relaxation = 1.5: must lie in \(0, 1\]"),
        ({"max_sweeps": 0}, "max_sweeps = 0: must be at least 1"),
    ],
)
def test_bad_iteration_settings_are_named(machine, options, message):
    with pytest.raises(InputError, match=message):
        build_flow("iterative", machine, **options)


def test_bad_settings_of_another_layout_are_named():
    with pytest.raises(InputError, match="eps = 2"):
        build_flow("iterative", "wheel_loader", eps=2.0)


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler to sweep in time")
def test_closer_sweeps_come_closer_to_the_exact_run_of_any_layout():
    exact = simulate("wheel_loader", "exact", "wheel_loader_cycle", t_end=2.5)
    errors = []
    for eps, relaxation in ((0.05, 0.2), (0.001, 0.05)):
        model = build_flow("iterative", "wheel_loader", eps=eps, relaxation=relaxation, max_sweeps=2000)
        run = simulate("wheel_loader", model, "wheel_loader_cycle", t_end=2.5)
        assert run.info["flow"] == "iterative"
        assert "work.p_pump" in run.names
        errors.append(np.abs(exact["lift.angle"] - run["lift.angle"]).max())
    assert 0.0 < errors[1] < 0.1 * errors[0]
