"""Batches: the bits of `simulate` for every machine, however machines are mixed, and lanes that are vector instructions."""

import dataclasses
import re

import numba
import numpy as np
import pytest

from helpers.small_crane import with_effects
from helpers.valves import changed
from polydraulic import (
    AbductiveRegressor,
    build_flow,
    load_machine,
    load_scenario,
    simulate,
    simulate_batch,
)
from polydraulic.errors import InputError
from polydraulic.flow.lanes import LANES
from polydraulic.flow.layout.database import sample_circuit
from polydraulic.flow.layout.slots import pressure_before
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Variable
from polydraulic.parameters.layout.parts import FlowForce
from polydraulic.parameters.scenario import Scenario, scenario_names
from polydraulic.parameters.schema import Stops
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.batch.batch import _blocks, _singles
from polydraulic.simulation.batch.batch_inputs import arrange_cases
from polydraulic.simulation.batch.family import tips_of
from polydraulic.simulation.lane_blocks import Kept
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.thesis.boom_models import fit_columns
from polydraulic.thesis.excavator import LINKS, with_pumps

PLAIN = bool(numba.config.DISABLE_JIT)
SECONDS = 0.02 if PLAIN else 10.0  # in plain Python a block takes 64 times as long as a machine
BOOM_ONLY = build_flow(
    "polynomial", load_machine("cat215b"), models=[m for m in shipped_models() if m.output.name.startswith("boom.")]
)
UP = Scenario("up", 4.0, {"boom": Constant(0.62)}, ("swing", "stick"))


def limited(machine):
    return with_pumps(machine, torque_limit_enabled=True)


def varied(machine, rng):
    """The machine with other masses, areas, friction, hoses, pilots, stops and pumps."""

    def scaled(part, **widths):
        return part._replace(**{k: getattr(part, k) * rng.uniform(1.0 - w, 1.0 + w) for k, w in widths.items()})

    def valve(v):
        curves = (tuple(k * rng.uniform(0.8, 1.2) for k in curve) for curve in v[1:])
        return type(v)(v.knots, *curves)

    functions = tuple(
        f._replace(
            pilot=scaled(f.pilot, gain=0.3, time_constant=0.3),
            valve=valve(f.valve),
            line=scaled(f.line, compliance_a=0.3, leakage=0.5),
            friction=scaled(f.friction, coulomb=0.5, viscous=0.3),
            stops=scaled(f.stops, low=0.1, high=0.1),
        )
        for f in machine.functions
    )
    swing, boom, stick = machine.links
    boom = scaled(boom, mass=0.3)._replace(at={key: x * rng.uniform(0.7, 1.3) for key, x in boom.at.items()})
    circuits = tuple(c._replace(pump=scaled(c.pump, flow=0.2, relief=0.1)) for c in machine.circuits)
    made = machine._replace(links=(swing, boom, stick), functions=functions, circuits=circuits)
    return with_pumps(made, torque_limit_enabled=bool(rng.random() < 0.5))


def assert_same(batch, place, table):
    common = [name for name in table.names if name in batch.names]
    assert len(common) >= len(table.names) - 4  # time and voltages
    for name in common:
        assert np.array_equal(batch[name][place], table[name]), name


@pytest.mark.parametrize("adapt", [lambda machine: machine, limited], ids=["constant flow", "torque limit"])
def test_mixed_scenarios_have_the_bits_of_simulate(machine, adapt):
    scenarios = [load_scenario(name) for name in scenario_names("cat215b")]
    batch = simulate_batch(adapt(machine), "exact", scenarios, t_end=SECONDS, keep=["rows"])
    assert batch.rows.shape == (len(scenarios), round(SECONDS / 0.005) + 1, len(batch.names))
    for place, scenario in enumerate(scenarios):
        assert_same(batch, place, simulate(adapt(machine), "exact", scenario, t_end=SECONDS))


def test_one_machine(machine):
    scenario = load_scenario("task")
    batch = simulate_batch(machine, "exact", scenario, t_end=SECONDS, keep=["rows"], every=3)
    table = simulate(machine, "exact", scenario, t_end=SECONDS, every=3)
    assert_same(batch, 0, table)
    assert np.array_equal(batch.time, table["time"])
    back = batch.table(0)
    assert all(back.unit(name) == table.unit(name) for name in back.names)
    assert np.array_equal(back["effector.z"], table["effector.z"])


def test_machines_that_differ_have_the_bits_of_simulate(machine):
    """More than a block, not a whole number of blocks; some limit the torque, some reach a stop."""
    rng = np.random.default_rng(0)
    n, seconds = (3, 0.01) if PLAIN else (LANES + 7, 13.0)
    machines = [varied(machine, rng) for _ in range(n)]
    scenario = load_scenario("step")
    batch = simulate_batch(machines, "exact", scenario, t_end=seconds, keep=["rows"])
    for place in range(n):
        assert_same(batch, place, simulate(machines[place], "exact", scenario, t_end=seconds))
    gaps = [
        np.abs(batch[f"{link}.angle"][place] - stop).min()
        for place, one in enumerate(machines)
        for link in LINKS
        for stop in one.function(link).stops
    ]
    assert PLAIN or min(gaps) < 0.01


@pytest.mark.parametrize("adapt", [lambda machine: machine, limited], ids=["constant flow", "torque limit"])
def test_single_steps_from_random_states(machine, adapt):
    """States at and beyond their bounds, one step each."""
    machine, rng, n = adapt(machine), np.random.default_rng(1), 3 if PLAIN else 4000
    reach = np.repeat([0.02, 3e7, 3e7, 3.0, 1.5], 3)
    x0 = reach * rng.uniform(-1.0, 1.0, (n, 15))
    x0[:, 3:9] = abs(x0[:, 3:9])
    voltage = rng.uniform(-1.2, 1.2, (n, 1, 3))
    batch = simulate_batch(machine, "exact", voltage, x0=x0, keep=["rows"])
    ready, n_record = prepare_layout(machine, 0.005), len(columns_of(machine).columns)
    rows, places = np.empty((2, n_record)), [row for row, _ in _columns_of(machine).values()]
    recorded = [i for i, row in enumerate(places) if row < n_record]
    for i in range(n):
        counts = np.zeros(2, dtype=np.int64)
        made = ready.module.run(ready.valves, np.zeros(1), ready.plant, x0[i], voltage[i], 1, rows, counts)
        assert made == batch.steps[i] == 1
        assert np.array_equal(batch.rows[i][:, recorded], rows[:, [places[c] for c in recorded]])


def _columns_of(machine):
    cases = arrange_cases(machine, "exact", np.zeros((1, 3)), dt=0.005, t_end=None, x0=None, every=1)
    return cases.family.columns(cases.free)


@pytest.mark.parametrize("name", ["polynomial", "neural"])
def test_networks_have_the_bits_of_simulate(machine, name):
    """By name, with a torque limit here and there, so that networks differ; then the same networks for machines whose numbers differ."""
    rng = np.random.default_rng(7)
    n, seconds = (3, 0.01) if PLAIN else (LANES + 9, 0.5)
    others = [machine, limited(machine) if name == "polynomial" else machine]
    others.append(machine.with_values({"links.boom.mass": 2000.0}))
    mixed = [others[i] for i in rng.integers(0, 3, n)]
    scenarios = [load_scenario(s) for s in rng.choice(["sine", "task", "step", "pulse"], n)]
    networks = build_flow(name, machine)
    models = shipped_models("cascade" if name == "polynomial" else name, limited=name == "polynomial")
    given = build_flow(name, machine, models=models)
    for machines, flow in ((mixed, name), ([varied(machine, rng) for _ in range(n)], given), ([machine] * n, networks)):
        batch = simulate_batch(machines, flow, scenarios, t_end=seconds, keep=["rows"])
        for place, (one, scenario) in enumerate(zip(machines, scenarios, strict=True)):
            table = simulate(one, flow, scenario, t_end=seconds)
            assert_same(batch, place, table)
            assert batch.out_of_domain[place] == table.info["steps_out_of_domain"]


def outlets_by_flow(machine):
    """Networks of the package, outlets as flows of spool and root of the pressure drop instead of conductances of the spool alone."""
    rng, found = np.random.default_rng(3), []
    for f in machine.functions:
        spool, root = rng.uniform(-f.valve.knots[-1], f.valve.knots[-1], 300), rng.uniform(0.0, 5e3, 300)
        k = np.interp(spool, f.valve.knots, f.valve.outlet_positive, left=0.0)
        names = (Variable(f"{f.name}.spool", "m"), Variable(f"{f.name}.root_p_out", "Pa^0.5"))
        fitted = AbductiveRegressor(max_layers=2).fit(np.column_stack([spool, root]), k * root)
        found.append(fitted.to_model(names, Variable(f"{f.name}.q_out", "m3/s")))
    return [*(m for m in shipped_models() if not m.output.name.endswith(".k_out")), *found]


@pytest.mark.parametrize("keep", [[], ["rows"], ["range"]])
def test_outlets_that_read_pressures_have_the_bits_of_simulate(machine, keep):
    flow = build_flow("polynomial", machine, models=outlets_by_flow(machine))
    work = Scenario("all", 0.12, dict.fromkeys(machine.names, Constant(0.6)))
    batch = simulate_batch([machine, machine], flow, work, keep=keep)
    table = simulate(machine, flow, work)
    last = {name: table[name][-1] for name in batch.names}
    assert len(last) > 20
    for place in range(2):
        assert {name: batch.final[place, batch.place(name)] for name in last} == last


@pytest.mark.slow_to_compile
def test_flow_forces_beside_networks_of_pressure_have_the_bits_of_simulate():
    plain = load_machine("wheel_loader")
    loader = with_effects(plain, flow_force=FlowForce(2e4, 870.0, np.radians(69.0)))
    (c,), rng, models = plain.circuits, np.random.default_rng(2), []
    table = sample_circuit(plain, c.name, 300, rng=rng, pressure=(0.0, 2e7))
    for place in range(len(c.functions)):
        output, inputs = pressure_before(c, place)
        names = [variable.name for variable in inputs]
        models.append(fit_columns(AbductiveRegressor(max_layers=1), table, names, output.name, {}))
    no_limit = loader.with_values({f"{c.pump_path}.torque_limit_enabled": False})
    flow = build_flow("pressure", no_limit, models=models)
    work = Scenario("both", 0.12, dict.fromkeys(loader.names, Constant(0.6)))
    batch = simulate_batch([no_limit, no_limit], flow, work, keep=["rows"])
    table = simulate(no_limit, flow, work)
    assert np.any(table["tilt.flow_shift"] != 0.0)
    for name in ("lift.flow_shift", "tilt.flow_shift", "lift.q_in", "tilt.spool", "lift.angle"):
        assert np.array_equal(batch[name][1], table[name]), name


def test_what_would_break_after_the_end_breaks_nothing(machine):
    """A model that is given does not know other pumps: `simulate` never needs it to, and neither does a batch."""
    flow = build_flow("polynomial", machine)
    late = ["boom.pump_worn 10 % from 100 s"]
    batch = simulate_batch([machine] * 2, flow, "task", t_end=0.02, faults=late)
    table = simulate(machine, flow, "task", t_end=0.02, faults=late)
    assert batch.final[1, batch.place("boom.angle")] == table["boom.angle"][-1]


def test_equal_faults_are_one_kind_however_they_are_listed(machine):
    listed = iter([["boom.friction_high from 0.01 s"] for _ in range(5)])
    cases = arrange_cases(machine, "exact", "task", dt=5e-3, t_end=0.02, x0=None, every=1, faults=listed)
    assert len(cases.kind) == 5
    assert len(cases.kinds) == 2


@pytest.mark.parametrize("name", ["iterative", "lookup"])
def test_models_without_lanes_run_one_by_one(machine, build, name):
    flow = build(name, machine)
    scenarios = [load_scenario("single_08"), load_scenario("single_05")]
    batch = simulate_batch(machine, flow, scenarios, t_end=0.1, keep=["rows"])
    for place, scenario in enumerate(scenarios):
        table = simulate(machine, flow, scenario, t_end=0.1)
        assert_same(batch, place, table)
        assert batch.not_converged[place] == table.info["steps_not_converged"]


@pytest.mark.parametrize("flow", ["exact", "polynomial"])
def test_both_ways_give_the_same(machine, flow):
    """Lanes and machine by machine, with the same flow model; one begins outside of what networks know."""
    machines = [machine, limited(machine), machine]
    x0 = np.tile(prepare_layout(machine, 0.005).start, (3, 1))
    x0[2, 3:9] = 4e7
    found = []
    for work in (_blocks, _singles):
        cases = arrange_cases(machines, flow, load_scenario("step"), dt=0.005, t_end=0.02, x0=x0, every=1)
        columns = np.array([row for row, _ in cases.family.columns(cases.free).values()])
        shape = (3, len(columns))
        ends = np.full(shape, np.inf)
        kept = Kept(
            columns,
            True,
            2,
            np.empty((3, 3, len(columns))),
            np.empty(shape),
            ends,
            -ends,
            tips_of(cases.family, [machine] * LANES, 0),
        )
        counts = np.zeros((3, 4), dtype=np.int64)
        assert sum(task() for task in work(cases, kept, counts)) == 3
        found.append([kept.rows, kept.final, kept.lowest, kept.highest, counts])
    assert all(np.array_equal(a, b) for a, b in zip(*found, strict=True))
    assert (found[0][-1][2, 2] > 0) == (flow != "exact")


def test_what_is_kept(machine):
    rng = np.random.default_rng(3)
    voltage = rng.uniform(-0.9, 0.9, (4, 6 if PLAIN else 200, 3))
    names = ["boom.p_in", "series.p_pump", "stick.rate"]
    batch = simulate_batch(machine, "exact", voltage, keep=["rows", "range"], columns=names)
    assert batch.names == tuple(names)
    assert np.array_equal(batch.final, batch.rows[:, -1])
    assert np.array_equal(batch.lowest, batch.rows.min(axis=1))
    assert np.array_equal(batch.highest, batch.rows.max(axis=1))
    assert np.array_equal(batch["stick.rate"], batch.rows[:, :, 2])
    alone = simulate_batch(machine, "exact", voltage, columns=names)
    assert np.array_equal(alone.final, batch.final)
    assert alone.rows is alone.lowest is alone.highest is None
    thinned = simulate_batch(machine, "exact", voltage, keep=["rows"], columns=names, every=5)
    assert np.array_equal(thinned.rows, batch.rows[:, ::5])
    assert np.array_equal(thinned.final, batch.final)


def test_columns_of_the_effector_bring_the_angles(machine):
    batch = simulate_batch(machine, "exact", np.zeros((2, 3)), columns=["effector.z", "boom.rate"])
    assert batch.names == (
        "boom.rate",
        "swing.angle",
        "boom.angle",
        "stick.angle",
        "effector.x",
        "effector.y",
        "effector.z",
    )
    assert batch.units["effector.z"] == "m"
    with pytest.raises(InputError, match=r"effector.z have no range"):
        simulate_batch(machine, "exact", np.zeros((2, 3)), columns=["effector.z"], keep=["range"])


def test_results_do_not_depend_on_threads(machine):
    n, steps = (2, 2) if PLAIN else (3 * LANES + 5, 100)
    voltage = np.random.default_rng(4).uniform(-0.9, 0.9, (n, steps, 3))
    seen = []
    batches = [
        simulate_batch(
            machine, "exact", voltage, threads=threads, keep=["rows", "range"], progress=lambda *s: seen.append(s)
        )
        for threads in (1, 3)
    ]
    for name in ("rows", "final", "lowest", "highest", "steps"):
        assert np.array_equal(*(getattr(batch, name) for batch in batches))
    assert seen[-1] == ("simulate", n, n)
    assert len(seen) == 2 * -(-n // LANES)


def test_initial_states_and_shared_voltages(machine):
    scenario = load_scenario("task")
    start = simulate(machine, "exact", scenario, t_end=0.02)
    state = [start[f"{link}.{name}"][-1] for name in ("spool", "p_a", "p_b", "angle", "rate") for link in LINKS]
    voltage = np.tile([0.3, -0.2, 0.1], (4, 1))
    one = simulate_batch(machine, "exact", voltage, x0=np.array(state), keep=["rows"])
    many = simulate_batch([machine] * 3, "exact", voltage, x0=np.array([state] * 3), keep=["rows"])
    assert one["boom.p_a"][0, 0] == start["boom.p_a"][-1]
    assert np.array_equal(many.rows, np.repeat(one.rows, 3, axis=0))


@pytest.mark.parametrize("flow", ["exact", "polynomial", "iterative"])
def test_a_machine_that_leaves_all_reason_does_not_spoil_the_others(machine, flow):
    wild = changed(machine, "boom", friction={"viscous": 1e30}, stops=Stops(-np.inf, np.inf))
    batch = simulate_batch([machine, wild], flow, UP, t_end=0.05, keep=["rows", "range"], columns=["boom.rate"])
    table = simulate(machine, flow, UP, t_end=0.05)
    assert np.array_equal(batch["boom.rate"][0], table["boom.rate"])
    assert batch.steps[0] == 10
    assert batch.steps[1] < 10
    kept = batch["boom.rate"][1]
    assert np.isfinite(kept[: batch.steps[1] + 1]).all()
    assert np.isnan(kept[batch.steps[1] + 1 :]).all()
    assert np.isnan([batch.final[1], batch.lowest[1], batch.highest[1]]).all()


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ({"n": 3, "inputs": np.zeros((2, 4, 3))}, {}, "3 machines, 2 inputs: each must be one for all machines"),
        ({"n": 2}, {"x0": np.zeros((5, 15))}, "2 machines, 1 inputs, 5 initial states"),
        ({"n": 0}, {}, "0 machines"),
        ({"inputs": np.zeros((4, 2))}, {}, "the array has shape (4, 2)"),
        ({"inputs": 3}, {}, "not int"),
        ({"inputs": np.full((2, 3), np.nan)}, {}, "the swing voltage in step 0 of machine 0 is nan"),
        ({"inputs": np.zeros((4, 3))}, {"t_end": 1.0}, "t_end = 1.0 s: the voltages last 4 steps"),
        ({"flow": BOOM_ONLY}, {}, "serves boom; give scenarios that lock the others"),
        ({"inputs": [UP, dataclasses.replace(UP, name="long", duration=5.0)]}, {}, "up 4 s, long 5 s); give t_end"),
        ({"flow": "none"}, {}, "unknown flow model 'none'"),
        ({"inputs": np.full((2, 3), 1j)}, {}, "the array holds values of type complex128"),
        ({"inputs": np.ma.masked_less(np.eye(3), 1.0)}, {}, "the array holds masked values"),
        ({}, {"x0": ["a"]}, "x0 = ['a']: must hold numbers"),
        ({}, {"x0": [[0.0], [0.0, 1.0]]}, "must hold numbers, as many for each machine"),
        ({}, {"x0": np.eye(15)[10] * 30.0}, "x0: boom.angle = 30 rad of machine 0: is far beyond the stops"),
        ({}, {"x0": np.zeros(14)}, "x0 has shape (14,)"),
        ({}, {"x0": np.full(15, np.inf)}, "must hold finite numbers"),
        ({}, {"keep": "rows"}, "keep = 'rows': must be a list of"),
        ({}, {"keep": ["all"]}, "keep = ['all']"),
        ({}, {"columns": ["boom.speed"]}, "columns = ['boom.speed']: must be some of ['swing.spool'"),
        ({}, {"threads": 0}, "threads = 0: must be a whole number"),
        ({}, {"every": 0}, "every = 0"),
        ({}, {"dt": 0.0}, "dt = 0.0 s: the time step must be positive"),
    ],
)
def test_bad_arguments_are_named(machine, arguments, options, message):
    given = {"n": 1, "flow": "exact", "inputs": np.zeros((4, 3)), **arguments}
    with pytest.raises(InputError, match=re.escape(message)):
        simulate_batch([machine] * given["n"], given["flow"], given["inputs"], **options)


def test_a_batch_says_what_it_has(machine):
    batch = simulate_batch([machine] * 2, "exact", np.zeros((1, 3)))
    assert len(batch) == 2
    with pytest.raises(InputError, match="the batch has no rows; ask for them"):
        batch["boom.angle"]
    with pytest.raises(InputError, match="no column 'boom.speed'; the batch has"):
        batch.place("boom.speed")


def test_machines_and_scenarios_may_be_given_by_name(machine):
    scenario = load_scenario("single_08")
    short = {"t_end": 0.02, "keep": ["rows"]}
    named = simulate_batch(["cat215b", machine, "cat215b"], "exact", ["single_08", scenario, "single_08"], **short)
    assert np.array_equal(named.rows, simulate_batch([machine] * 3, "exact", scenario, **short).rows)
    one = simulate_batch("cat215b", "exact", "single_08", **short)
    assert np.array_equal(one.rows[0], named.rows[2])
    with pytest.raises(InputError, match="unknown scenario 'dig'"):
        simulate_batch(machine, "exact", "dig")
    with pytest.raises(InputError, match="given by its name .*, not as int"):
        simulate_batch([machine, 3], "exact", "single_08")
