"""Tables: right at their points, of second order between them, clamped beyond them."""

import numba
import numpy as np
import pytest

from helpers.excavator_tree import excavator_tree
from helpers.flow_steps import Links, flow_step
from polydraulic import build_flow, simulate
from polydraulic.errors import InputError
from polydraulic.flow import OK, OUT_OF_DOMAIN, exact_flow, lookup_flow, neural_flow, table_bytes
from polydraulic.flow.lookup import pressure_lines, travel_lines
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.thesis.excavator import pump_of, spool_of, with_pumps
from polydraulic.units import to_si

PSI = to_si(1.0, "psi")
PLAIN = bool(numba.config.DISABLE_JIT)


@pytest.fixture(scope="module", params=[False, True], ids=["constant", "limited"])
def pumped(request, machine):
    return with_pumps(machine, torque_limit_enabled=request.param)


@pytest.fixture(scope="module")
def coarse(machine):
    return lookup_flow(machine, points=6)


def step(machine, model, spool, p_in):
    return flow_step(machine, model, np.zeros(1), spool, p_in, Links(0.0, 0.0, 0.0))


def links(boom, swing, stick):
    return Links(swing, boom, stick)


def states(machine, n, seed=0, highest=None):
    """Spools and pressures at random, each (n, 3)."""
    rng, travel = np.random.default_rng(seed), spool_of(machine).end
    return rng.uniform(-travel, travel, (n, 3)), rng.uniform(0.0, highest or pump_of(machine, "boom").relief, (n, 3))


def test_grid_points_are_exact(pumped):
    """Both circuits' flows and what the pumps deliver, with spools to either side."""
    n, rng, relief = 7, np.random.default_rng(2), pump_of(pumped, "boom").relief
    exact, model, full = exact_flow(pumped), lookup_flow(pumped, points=n), pump_of(pumped, "series").flow
    lines = [(travel_lines(pumped.functions[0].valve.knots, m), pressure_lines(relief, m)) for m in (4 * n, n, n)]
    for _ in range(100):
        spool = links(*(rng.choice([-1.0, 1.0]) * rng.choice(x) for x, _ in lines))
        p_in = links(*(rng.choice(p) for _, p in lines))
        ours, true = step(pumped, model, spool, p_in), step(pumped, exact, spool, p_in)
        assert ours.status == OK
        # where the root of what is left to relief begins, rounding of the pressure is a share 1e-7 of the flow
        assert ours.q_in == pytest.approx(true.q_in, abs=1e-6 * full)
        delivered = (ours.boom.q_pump, ours.series.q_pump)
        assert delivered == pytest.approx((true.boom.q_pump, true.series.q_pump), rel=1e-7)


def test_lines_meet_the_knots(machine):
    for n in (6, 7, 24, 64):
        lines = travel_lines(machine.functions[0].valve.knots, n)
        assert len(lines) == n
        assert np.all(np.diff(lines) > 0.0)
        assert set(machine.functions[0].valve.knots) <= set(lines)
        pressures = pressure_lines(pump_of(machine, "boom").relief, n)
        assert (pressures[0], pressures[-1], len(pressures)) == (0.0, pump_of(machine, "boom").relief, n)


def test_outlets_are_exact(machine, coarse):
    """The tables of the exact model are linear between the same knots, and differ with the sign of the spool."""
    spool, p = states(machine, 300)
    k, true = sample_flow(machine, coarse, spool, p, p).k_out, sample_flow(machine, "exact", spool, p, p).k_out
    assert k == pytest.approx(true, rel=1e-12, abs=1e-12 * true.max())
    assert abs(k[spool > 0.0].max() - k[spool < 0.0].max()) > 0.01 * true.max()


@pytest.mark.skipif(PLAIN, reason="needs the compiler to fill the tables in time")
def test_errors_are_of_second_order_away_from_kinks(machine):
    """All inlets and bypasses open, relief valve shut, between two knots: twice the points, a quarter of the error."""
    knots, rng, n = machine.functions[0].valve.knots, np.random.default_rng(1), 1000
    spool = rng.uniform(1.05 * knots[2], 0.95 * knots[3], (n, 3))
    p_in = rng.uniform([900.0 * PSI, 300.0 * PSI, 100.0 * PSI], [1100.0 * PSI, 500.0 * PSI, 200.0 * PSI], (n, 3))
    true = sample_flow(machine, "exact", spool, p_in, p_in)
    assert np.all(true.q_in > 0.1 * pump_of(machine, "series").flow)
    assert np.all(true.p_pump < 0.5 * pump_of(machine, "boom").relief)
    models = [lookup_flow(machine, points=m) for m in (24, 48)]
    errors = [np.abs(sample_flow(machine, model, spool, p_in, p_in).q_in - true.q_in).mean(axis=0) for model in models]
    order = np.log2(errors[0] / errors[1])
    assert np.all((order > 1.7) & (order < 2.4))


def test_pressures_beyond_the_tables_are_clamped_and_reported(machine, coarse):
    spool, relief = Links(0.008, 0.008, 0.008), pump_of(machine, "boom").relief
    inside = Links(300.0 * PSI, 300.0 * PSI, 300.0 * PSI)
    assert step(machine, coarse, spool, inside).status == OK
    for link in Links._fields:
        for beyond, end in ((1.2 * relief, relief), (-1e5, 0.0)):
            ours, at_end = (step(machine, coarse, spool, inside._replace(**{link: p})) for p in (beyond, end))
            assert (ours.status, at_end.status) == (OUT_OF_DOMAIN, OK)
            assert ours._replace(status=OK) == at_end
    lost = step(machine, coarse, spool, inside._replace(boom=np.nan))
    assert lost.status == OUT_OF_DOMAIN
    assert np.isfinite(lost.q_in.boom)


def test_a_spool_beyond_its_end_stands_at_it(machine, coarse):
    end, p = spool_of(machine).end, Links(1e6, 1e6, 1e6)
    for sign in (-1.0, 1.0):
        spools = (Links(*[sign * share * end] * 3) for share in (1.0, 1.5))
        assert step(machine, coarse, next(spools), p) == step(machine, coarse, next(spools), p)


def test_special_cases_hold_between_points(pumped):
    """Nothing enters at relief; nothing in the deadband; a first valve shut off passes nothing on; no flow is made."""
    model, spool, relief = lookup_flow(pumped, points=6), spool_of(pumped), pump_of(pumped, "boom").relief
    for x, p in zip(*states(pumped, 200), strict=True):
        at_relief = step(pumped, model, Links(*x), Links(relief, relief, relief))
        assert at_relief.q_in == (0.0, 0.0, 0.0)
        flows = step(pumped, model, Links(*x), Links(*p))
        assert flows.q_in.swing + flows.q_in.stick <= flows.series.q_pump * (1.0 + 1e-15)
        assert 0.0 <= flows.q_in.boom <= flows.boom.q_pump <= pump_of(pumped, "boom").flow * (1.0 + 1e-15)
        shares = x / spool.end
        assert step(pumped, model, Links(*(shares * spool.deadband)), Links(*p)).q_in == (0.0, 0.0, 0.0)
        shut = spool.bypass_closed + abs(shares[0]) * (spool.end - spool.bypass_closed)
        assert step(pumped, model, Links(shut, x[1], x[2]), Links(*p)).q_in.stick == 0.0


@pytest.mark.skipif(PLAIN, reason="needs the compiler to fill the tables in time")
def test_the_usual_tables_are_small_and_near_exact(pumped):
    model, full = build_flow("lookup", pumped), pump_of(pumped, "series").flow
    assert table_bytes(model.parts) < 1e7
    spool, p_in = states(pumped, 20000)
    error = (
        sample_flow(pumped, model, spool, p_in, p_in).q_in - sample_flow(pumped, "exact", spool, p_in, p_in).q_in
    ) / full
    assert np.all(np.sqrt(np.mean(error**2, axis=0)) < [0.008, 0.002, 0.008])


def test_bytes_of_tables_are_counted(machine, coarse):
    floats = 2 * 6 + 6**4 * 2 + 24 + 24**2  # lines and flows of both circuits
    assert table_bytes(coarse.parts) == 8 * floats
    assert table_bytes(exact_flow(machine).parts) == 0
    assert table_bytes(neural_flow(machine).parts) > 0


@pytest.mark.parametrize("points", [5, 65, 0, -8, 20.0, "many", None])
def test_bad_points_are_refused(machine, points):
    with pytest.raises(
        InputError, match=f"points = {points!r}: must be a whole number from 6, the most knots of a spool, to 64"
    ):
        lookup_flow(machine, points=points)


@pytest.mark.slow_to_compile
def test_tables_of_any_layout_are_exact_at_their_points():
    """One valve with its torque limit in a table of its own, two valves in another."""
    tree, points = excavator_tree(), 6
    c = tree.circuits[0]
    tree = tree._replace(circuits=(c._replace(pump=c.pump._replace(torque_limit_enabled=True)), *tree.circuits[1:]))
    ready, exact = (
        prepare_layout(tree, 5e-3, flow=model) for model in (build_flow("lookup", tree, points=points), None)
    )
    knots, relief, rng = tree.functions[0].valve.knots, c.pump.relief, np.random.default_rng(2)
    lines = {
        f: (travel_lines(knots, m), pressure_lines(relief, m)) for f, m in zip(tree.names, (6, 24, 6), strict=True)
    }
    functions = ready.module.Functions
    for _ in range(40):
        spool = functions(*(rng.choice([-1.0, 1.0]) * rng.choice(lines[f][0]) for f in tree.names))
        p_in = functions(*(rng.choice(lines[f][1]) for f in tree.names))
        ours = ready.module.flow_step(ready.valves, np.zeros(1), spool, p_in, p_in, 5e-3)
        true = exact.module.exact_step(exact.valves, exact.module.Functions(*spool), exact.module.Functions(*p_in))
        assert ours.status == OK
        assert tuple(ours.q_in) == pytest.approx(tuple(true.q_in), abs=1e-6 * c.pump.flow)
        assert tuple(ours.k_out) == tuple(true.k_out)
        assert ours.circuit_boom.q_pump == pytest.approx(true.circuit_boom.q_pump, rel=1e-7)
    beyond = ready.module.flow_step(ready.valves, np.zeros(1), spool, p_in._replace(stick=1.2 * relief), p_in, 5e-3)
    assert beyond.status == OUT_OF_DOMAIN


def test_circuits_of_more_than_two_valves_are_refused_by_name():
    with pytest.raises(
        InputError, match=r"'lookup' is for circuits of at most 2 valves in series; circuit 'slew_and_reach' has 3"
    ):
        build_flow("lookup", "loader_crane")
    with pytest.raises(
        InputError, match="points = 65: must be a whole number from 6, the most knots of a spool, to 64"
    ):
        build_flow("lookup", "wheel_loader", points=65)


@pytest.mark.slow
def test_more_points_come_closer_to_the_exact_run_of_any_layout():
    exact = simulate("wheel_loader", "exact", "wheel_loader_cycle")
    errors = []
    for points in (8, 24):
        run = simulate("wheel_loader", build_flow("lookup", "wheel_loader", points=points), "wheel_loader_cycle")
        assert "work.p_pump" not in run.names
        errors.append(np.abs(exact["lift.angle"] - run["lift.angle"]).max())
    assert 0.0 < errors[1] < 0.5 * errors[0]
