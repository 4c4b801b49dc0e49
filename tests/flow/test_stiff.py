"""Pump pressures as states: each step against a bracketed solve, the oil in the volumes, and the way to exact."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.optimize import brentq

from helpers.flow_steps import Links, flow_step, held_still
from helpers.valves import circuit_pump, orifices
from polydraulic import build_flow, compare, load_scenario, reference, simulate
from polydraulic.errors import InputError
from polydraulic.machine.pump import delivered
from polydraulic.thesis.excavator import spool_of, with_pumps
from polydraulic.units import to_si

PSI = to_si(1.0, "psi")
DT = 0.005
VOLUMES = {"volume": 1e-3, "volume_between": 2e-4}
COMPLIANCE, BETWEEN = 1e-12, 2e-13


@pytest.fixture(scope="module", params=[False, True], ids=["constant", "limited"])
def pumped(request, machine):
    return with_pumps(machine, torque_limit_enabled=request.param)


def q(k, drop):
    return k * math.sqrt(max(drop, 0.0))


def root(f, high):
    return brentq(f, 0.0, high, xtol=1e-12, rtol=1e-14, maxiter=500) if f(high) > 0.0 else high


def judged(machine, spool, p_in, before):
    """Pressures after a step of backward Euler, one bracket inside the other."""
    boom, series = circuit_pump(machine, "boom"), circuit_pump(machine, "series")
    ks, kb, kt = (orifices(x, f.valve) for x, f in zip(spool, machine.functions, strict=True))

    def single(p):
        stored = COMPLIANCE * (p - before[0]) / DT
        return stored + q(kb.inlet, p - p_in.boom) + q(kb.bypass, p - boom.p_return) - delivered(p, boom)

    def between(p):
        def surplus(b):
            drawn = q(kt.inlet, b - p_in.stick) + q(kt.bypass, b - series.p_return)
            return BETWEEN * (b - before[2]) / DT + drawn - q(ks.bypass, p - b)

        return root(surplus, 2.0 * series.relief)

    def pair(p):
        stored = COMPLIANCE * (p - before[1]) / DT
        return stored + q(ks.inlet, p - p_in.swing) + q(ks.bypass, p - between(p)) - delivered(p, series)

    p = root(pair, series.relief)
    return root(single, boom.relief), p, between(p)


def test_a_step_against_the_judge(pumped):
    model = build_flow("stiff", pumped, **VOLUMES)
    rng = np.random.default_rng(0)
    boom, series = circuit_pump(pumped, "boom"), circuit_pump(pumped, "series")
    travel, relief = spool_of(pumped).end, boom.relief
    for _ in range(60):
        spool, p_in = Links(*rng.uniform(-travel, travel, 3)), Links(*rng.uniform(0.0, relief, 3))
        before = rng.uniform(0.0, relief, 3)
        memory = np.array([*before, 1.0])
        flows = flow_step(pumped, model, memory, spool, p_in, p_in, DT)
        expected = judged(pumped, spool, p_in, before)
        assert memory[:3] == pytest.approx(expected, rel=1e-7, abs=1.0)
        assert (flows.boom.p_pump, flows.series.p_pump, flows.p_between) == tuple(memory[:3])
        # flows are those that the pressures drive, and the volumes hold what they do not
        stored = COMPLIANCE * (memory[0] - before[0]) / DT
        assert flows.boom.q_stored == pytest.approx(stored, abs=1e-9 * flows.boom.q_pump)
        stored = (COMPLIANCE * (memory[1] - before[1]) + BETWEEN * (memory[2] - before[2])) / DT
        assert flows.series.q_stored == pytest.approx(stored, abs=1e-9 * flows.series.q_pump)
        assert flows.boom.q_pump == pytest.approx(delivered(memory[0], boom), rel=1e-8)
        assert flows.series.q_pump == pytest.approx(delivered(memory[1], series), rel=1e-8)
        k = orifices(spool.boom, pumped.function("boom").valve)
        assert flows.q_in.boom == pytest.approx(q(k.inlet, memory[0] - p_in.boom), abs=1e-7 * flows.boom.q_pump)


@pytest.mark.parametrize("volume", [1e-6, 1e-3, 1e-1])
def test_held_still_it_becomes_exact(pumped, volume):
    model, exact = build_flow("stiff", pumped, volume=volume, volume_between=volume), build_flow("exact", pumped)
    spool, p_in = Links(0.0075, -0.0065, 0.0071), Links(500 * PSI, 1500 * PSI, 900 * PSI)
    memory = np.array([1e5, 3e7, 1e5, 1.0])
    flows = held_still(pumped, model, memory, spool, p_in, 3000)
    still = flow_step(pumped, exact, np.zeros(1), spool, p_in, p_in, DT)
    assert flows.q_in == pytest.approx(still.q_in, rel=1e-6)
    assert flows.series[:4] == pytest.approx(still.series[:4], rel=1e-6, abs=1e-12)
    assert flows.p_between == pytest.approx(still.p_between, rel=1e-6)


def test_it_begins_at_rest(pumped):
    spool, p_in = Links(0.0075, -0.0065, 0.0071), Links(500 * PSI, 1500 * PSI, 900 * PSI)
    flows = flow_step(pumped, build_flow("stiff", pumped), np.zeros(4), spool, p_in, p_in, DT)
    still = flow_step(pumped, build_flow("exact", pumped), np.zeros(1), spool, p_in, p_in, DT)
    assert flows.q_in == pytest.approx(still.q_in, rel=1e-7)
    assert abs(flows.series.q_stored) < 1e-7 * flows.series.q_pump


@pytest.mark.slow_to_compile
def test_a_run_of_another_layout_loses_no_oil():
    run = simulate("wheel_loader", build_flow("stiff", "wheel_loader", **VOLUMES), "wheel_loader_cycle", t_end=1.0)
    stored = COMPLIANCE * np.diff(run["work.p_pump"]) + BETWEEN * np.diff(run["work.p_between"])
    assert DT * run["work.q_stored"][1:] == pytest.approx(stored, abs=1e-14)
    moved = sum(run[f"{f}.q_in"] for f in run.info["circuits"]["work"])
    given = moved + run["work.q_bypass"] + run["work.q_relief"] + run["work.q_stored"]
    assert given == pytest.approx(run["work.q_pump"], rel=1e-9)


def test_volumes_lose_no_oil(pumped):
    scenario = load_scenario("step")
    run = simulate(pumped, build_flow("stiff", pumped, **VOLUMES), scenario, t_end=3.0)
    stored = COMPLIANCE * np.diff(run["boom.p_pump"])
    assert DT * run["boom.q_stored"][1:] == pytest.approx(stored, abs=1e-14)
    stored = COMPLIANCE * np.diff(run["series.p_pump"]) + BETWEEN * np.diff(run["series.p_between"])
    assert DT * run["series.q_stored"][1:] == pytest.approx(stored, abs=1e-14)
    assert np.abs(run["series.q_stored"]).max() > 1e-3 * run["series.q_pump"].max()


@pytest.mark.slow
def test_the_flows_approach_exact_as_the_volumes_shrink(pumped):
    """First order in the volume: the pump's oil takes up C dP/dt."""
    scenario, volumes = load_scenario("task"), np.array([1e-3, 1e-4, 1e-5])
    exact = simulate(pumped, "exact", scenario, t_end=6.0)
    runs = [
        simulate(pumped, build_flow("stiff", pumped, volume=v, volume_between=0.2 * v), scenario, t_end=6.0)
        for v in volumes
    ]
    for column in ("swing.q_in", "boom.q_in", "stick.q_in", "series.p_pump", "series.p_between"):
        errors = [compare(exact, run)[column].rms for run in runs]
        order = np.polyfit(np.log(volumes), np.log(errors), 1)[0]
        assert 0.85 < order < 1.15, column


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"volume": 0.0}, "volume = 0.0 m3: must be positive and finite; flow 'exact' has no volumes"),
        ({"volume_between": -1.0}, "volume_between = -1.0 m3"),
        ({"bulk_modulus": float("inf")}, "bulk_modulus = inf Pa"),
    ],
)
def test_bad_volumes_are_named(machine, options, message):
    for name, given in product(("stiff", "tlm"), (machine, "wheel_loader")):
        with pytest.raises(InputError, match=message):
            build_flow(name, given, **options)


def test_the_reference_refuses_pressures_of_a_models_own(machine):
    for name in ("stiff", "tlm"):
        with pytest.raises(InputError, match=f"flow '{name}' with method 'reference'"):
            reference(machine, name, load_scenario("sine"), t_end=0.1)
