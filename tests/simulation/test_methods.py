"""Methods of `simulate`: the order of each, and that all give the same run."""

import numpy as np
import pytest

from polydraulic import load_scenario, random_operator, simulate
from polydraulic.errors import InputError
from polydraulic.flow import exact_flow
from polydraulic.flow.record import N_RECORD
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links, State
from polydraulic.parameters.scenario import Scenario, scenario_names
from polydraulic.parameters.schema import LINKS
from polydraulic.parameters.signals import Constant, Piecewise
from polydraulic.simulation.events import edges_of, new_log
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import METHODS
from polydraulic.simulation.solvers.right_hand_side import held_at_stops, rates, resting
from polydraulic.simulation.solvers.rosenbrock import DONE, run_rosenbrock
from polydraulic.simulation.solvers.rosenbrock_step import RODAS, new_work
from polydraulic.simulation.solvers.runge_kutta import run_runge_kutta
from polydraulic.simulation.solvers.spools import N_COEFFICIENT, SpoolMotion

# All valves stay on one segment of their tables after 0.8 s, and no line meets a bound: nothing but smooth motion.
VOLTS = (0.41, 0.3, 0.62)
SMOOTH = Scenario("smooth", 1.2, {link: Constant(v) for link, v in zip(LINKS, VOLTS, strict=True)})
START, LENGTH = 0.8, 0.4  # s


def angles(table):
    return np.column_stack([table[f"{link}.angle"] for link in LINKS])


def joint_errors(found, tight):
    """Largest error of each joint in degrees."""
    return np.degrees(np.abs(angles(found) - angles(tight)).max(axis=0))


@pytest.fixture(scope="module")
def tight(machine):
    """Tight solution of a scenario by its name."""
    found = {}

    def solution(name):
        if name not in found:
            found[name] = simulate(machine, "exact", load_scenario(name), method="reference", rtol=1e-9)
        return found[name]

    return solution


@pytest.fixture(scope="module")
def moving(machine):
    """State of the smooth run at its start, from small steps."""
    begun = simulate(machine, "exact", SMOOTH, t_end=START, dt=1e-3, method="rk4")
    return np.array(
        [begun[f"{link}.{name}"][-1] for name in ("spool", "p_a", "p_b", "angle", "rate") for link in LINKS]
    )


def end_by_runge_kutta(machine, x0, n):
    tau = Links(*(getattr(machine, link).pilot.time_constant for link in LINKS))
    rows, voltage = np.empty((2, N_RECORD)), np.tile(VOLTS, (2 * n + 1, 1))
    counts, plant = np.zeros(2, dtype=np.int64), prepare(machine, 1.0)
    made = run_runge_kutta(exact_flow(machine), np.zeros(1), plant, tau, LENGTH / n, x0, voltage, n, rows, counts)
    assert made == n
    return rows[1, :15]


def end_by_the_loop(machine, x0, n):
    rows, counts = np.empty((2, N_RECORD)), np.zeros(2, dtype=np.int64)
    plant = prepare(machine, LENGTH / n)
    assert run(exact_flow(machine), np.zeros(1), plant, x0, np.tile(VOLTS, (n, 1)), n, rows, counts) == n
    return rows[1, :15]


def end_by_rosenbrock(machine, x0, rtol):
    """Spools fading from where they are to their commands, in closed form."""
    c = np.zeros((1, 3, N_COEFFICIENT))
    for link, name in enumerate(LINKS):
        pilot = getattr(machine, name).pilot
        target = pilot.gain * VOLTS[link]
        c[0, link, 0], c[0, link, 2], c[0, link, 7] = target, x0[link] - target, 1.0 / pilot.time_constant
    motion = SpoolMotion(np.array([0.0, LENGTH]), c, np.array([LENGTH]))
    rows, counts = np.empty((2, N_RECORD)), np.zeros(4, dtype=np.int64)
    status = run_rosenbrock(
        exact_flow(machine), np.zeros(1), prepare(machine, 1.0), RODAS, motion, x0, rtol, np.array([0.0, LENGTH]),
        rows, counts, new_log(), edges_of(machine), new_work(RODAS),
    )  # fmt: skip
    assert status == DONE
    return rows[1, :15], int(counts[0])


def order(end, truth, numbers):
    errors = [np.abs(end(n)[9:] - truth[9:]).max() for n in numbers]
    return -np.polyfit(np.log(numbers), np.log(errors), 1)[0]


@pytest.mark.slow
def test_runge_kutta_is_of_fourth_order(machine, moving):
    truth = end_by_runge_kutta(machine, moving, 1280)
    assert 3.9 < order(lambda n: end_by_runge_kutta(machine, moving, n), truth, [80, 160, 320]) < 4.3


def test_the_semi_implicit_loop_is_of_first_order(machine, moving):
    truth = end_by_runge_kutta(machine, moving, 160)
    assert 0.9 < order(lambda n: end_by_the_loop(machine, moving, n), truth, [80, 160, 320]) < 1.1


def test_the_rosenbrock_method_is_of_fourth_order_in_its_steps(machine, moving):
    truth = end_by_rosenbrock(machine, moving, 1e-11)[0]
    assert truth == pytest.approx(end_by_runge_kutta(machine, moving, 160), rel=1e-6)
    ends = [end_by_rosenbrock(machine, moving, rtol) for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)]
    errors = [np.abs(end - truth)[9:].max() for end, _ in ends]
    steps = [n for _, n in ends]
    assert 3.5 < -np.polyfit(np.log(steps), np.log(errors), 1)[0] < 4.6
    assert all(error < 10.0 * rtol for error, rtol in zip(errors, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8), strict=True))


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
@pytest.mark.parametrize("name", scenario_names())
def test_the_rosenbrock_method_keeps_its_tolerance(machine, tight, name):
    """Joints within a hundred tolerances in radians, whatever happens on the way, and the same events at the same times."""
    for rtol in (1e-3, 1e-5, 1e-7):
        found = simulate(machine, "exact", load_scenario(name), method="rosenbrock", rtol=rtol)
        assert np.all(joint_errors(found, tight(name)) <= np.degrees(100.0 * rtol)), rtol
        ours, theirs = found.info["events"], tight(name).info["events"]
        assert [event[1:] for event in ours] == [event[1:] for event in theirs] or rtol == 1e-3
    assert [event[0] for event in ours] == pytest.approx([event[0] for event in theirs], abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", scenario_names())
def test_methods_agree_on_when_things_happen(machine, tight, name):
    """Spool edges within a step where voltages are held over it, and to a tenth of one where not; stops within 50 ms."""
    theirs = tight(name).info["events"]
    for method, spools in (("semi-implicit", 5e-3), ("rk4", 5e-4)):
        ours = simulate(machine, "exact", load_scenario(name), method=method).info["events"]
        for time, link, what in theirs:
            times = [event[0] for event in ours if event[1:] == [link, what]]
            limit = spools if "valve" in what or "bypass" in what else (0.05 if "stop" in what else np.inf)
            assert limit == np.inf or min(abs(t - time) for t in times) < limit, (method, link, what)


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


def test_stops_hold_what_they_push(machine):
    """Of boom and stick at their lower stops: for random line pressures the choice satisfies every stop."""
    plant, model, rng = prepare(machine, 1.0), exact_flow(machine), np.random.default_rng(3)
    low = Links(0.0, machine.boom.stops.low, machine.stick.stops.low)
    seen = set()
    for _ in range(100):
        p_a, p_b = (Links(*rng.uniform(0.0, 3e7, 3)) for _ in range(2))
        x = State(Links(0.0, 0.0, 0.0), p_a, p_b, low, Links(rng.uniform(-1.0, 1.0), 0.0, 0.0))
        rest = resting(x, 0.0, plant)
        held = held_at_stops(rest, x, rates(model, np.zeros(1), plant, rest, x), plant)
        r = rates(model, np.zeros(1), plant, held, x)
        for place in (1, 2):
            assert (r.reaction[place] if held[place] else r.acceleration[place]) >= -1e-6
        seen.add((held.boom, held.stick))
    assert len(seen) == 4


def test_the_rosenbrock_method_needs_slopes(machine):
    with pytest.raises(InputError, match=r"needs the slopes of the flows, which flow 'iterative' does not give"):
        simulate(machine, "iterative", SMOOTH, method="rosenbrock")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "euler"}, r"unknown method 'euler'; choose one of \['semi-implicit', 'rk4'"),
        ({"method": "rk4", "rtol": 1e-6}, "rtol = 1e-06 with method 'rk4': goes with"),
        ({"method": "reference", "rtol": 0.0}, "rtol = 0.0"),
        ({"method": "reference", "rtol": float("nan")}, "rtol = nan"),
    ],
)
def test_bad_settings_are_named(machine, options, message):
    with pytest.raises(InputError, match=message):
        simulate(machine, "exact", SMOOTH, **options)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_gives_the_same_columns(machine, method):
    found = simulate(machine, "exact", SMOOTH, t_end=0.1, dt=0.01, method=method)
    assert found.names == simulate(machine, "exact", SMOOTH, t_end=0.1, dt=0.01).names
    assert found.info["method"] == method
    assert len(found) == 11
    assert found["swing.spool"][-1] == pytest.approx(VOLTS[0] * 0.01397 * (1 - np.exp(-0.1 / 0.205)), rel=1e-6)
