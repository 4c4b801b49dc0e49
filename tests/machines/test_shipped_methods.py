"""Methods of `simulate` that integrate in continuous time, on every machine of links that comes with the package: one body for all."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from helpers.layout_states import check_jacobian, random_state, rates_of
from helpers.mechanical_energy import joint_columns
from polydraulic import compare, load_machine, reference, simulate
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import machine_names
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout

MACHINES = {name: load_machine(name) for name in machine_names()}
LAYOUTS = [name for name, m in MACHINES.items() if isinstance(m, LayoutMachine)]
QUICK = "wheel_loader"  # each layout is compiled once, for a minute
EACH = [pytest.param(name, marks=[] if name == QUICK else pytest.mark.slow) for name in LAYOUTS]
OPERATOR = "random:2:2"


@pytest.fixture(scope="module", params=EACH)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def plant(name):
    return load_machine(name)


@pytest.fixture(scope="module")
def tight(plant):
    return reference(plant, "exact", OPERATOR)


def joint_errors(plant, found, tight):
    """Largest errors of all positions, rad and m."""
    return np.abs(joint_columns(plant, found)[0] - joint_columns(plant, tight)[0]).max(axis=0)


def test_the_equations_are_the_limit_of_short_steps(plant):
    """What a step changes, over its length, at two lengths, the error of which is of first order."""
    rng, n, compared = np.random.default_rng(4), len(plant.names), 0
    columns = columns_of(plant)
    for _ in range(10):
        at = random_state(plant, rng)
        expected, _ = rates_of(at._replace(free=np.ones(2 * n)))
        volts = np.array([s / f.pilot.gain for s, f in zip(at.known, plant.functions, strict=True)])  # the spools stay
        x0, found = np.concatenate([at.known, at.y]), []
        for dt in (2e-6, 1e-6):
            ready, rows = prepare_layout(plant, dt), np.empty((2, len(columns.columns)))
            done = ready.module.run(
                ready.valves, np.zeros(1), ready.plant, x0, volts[None, :], 1, rows, np.zeros(2, dtype=np.int64)
            )
            assert done == 1
            found.append((rows[1, n : 5 * n] - at.y) / dt)
        limit = 2.0 * found[1] - found[0]
        size = np.maximum(np.abs(expected).reshape(4, -1).max(axis=1), 1e-9)
        error = np.abs(limit - expected).reshape(4, -1).max(axis=1) / size
        assert (error < 1e-4).all(), error
        compared += 1
    assert compared == 10


@pytest.mark.parametrize("options", [{}, {"locked": True}])
def test_steps_solve_with_the_true_jacobian(plant, options):
    options = {"locked": plant.names[-1:]} if options else {}
    assert check_jacobian(plant, np.random.default_rng(5), 15, **options) > 7


def test_the_rosenbrock_method_keeps_its_tolerance(plant, tight):
    for rtol in (1e-3, 1e-5, 1e-7):
        found = simulate(plant, "exact", OPERATOR, method="rosenbrock", rtol=rtol)
        assert found.names == tight.names
        assert joint_errors(plant, found, tight).max() < 100.0 * rtol
        ours, theirs = found.info["events"], tight.info["events"]
        assert [event[1:] for event in ours] == [event[1:] for event in theirs] or rtol == 1e-3
    assert [event[0] for event in ours] == pytest.approx([event[0] for event in theirs], abs=1e-4)
    assert compare(tight, found)["effector.distance"].largest < 1e-5


def test_fixed_steps_come_to_the_same_by_their_order(plant, tight):
    moved = np.ptp(joint_columns(plant, tight)[0], axis=0).max()
    coarse, fine = (
        joint_errors(plant, simulate(plant, "exact", OPERATOR, dt=dt, raster=5e-3), tight).max()
        for dt in (5e-3, 1.25e-3)
    )
    assert fine < 0.01 * moved
    assert 3.0 < coarse / fine < 5.5  # first order
    smooth = joint_errors(plant, simulate(plant, "exact", OPERATOR, dt=1.25e-3, raster=5e-3, method="rk4"), tight)
    assert smooth.max() < 0.2 * fine  # at stops and empty lines a step is of lower order


PLAIN = """
import sys
import numpy as np
from polydraulic import simulate

for number, method in enumerate(sys.argv[3:]):
    run = simulate(sys.argv[1], "exact", "random:1:2", t_end=1.0, method=method)
    np.save(f"{sys.argv[2]}_{number}.npy", np.column_stack([run[name] for name in run.names]))
"""


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_plain_python_has_the_bits_of_compiled_code(name, plant, tmp_path):
    found, methods = [], ["rk4", "rosenbrock"]
    for plain in ("0", "1"):
        path = tmp_path / plain
        environment = {**os.environ, "NUMBA_DISABLE_JIT": plain}
        subprocess.run([sys.executable, "-c", PLAIN, name, path, *methods], check=True, env=environment)
        found.append([np.load(f"{path}_{number}.npy") for number in range(len(methods))])
    for compiled, other in zip(*found, strict=True):
        assert len(compiled) == 201
        assert compiled.tobytes() == other.tobytes()
