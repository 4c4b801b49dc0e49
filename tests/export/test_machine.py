"""The machine as C next to the package: the same bits, at every step."""

import shutil
import subprocess

import numba
import numpy as np
import pytest

from helpers import c_machine
from helpers.stepped import stepped
from helpers.valves import changed
from polydraulic import load_scenario, simulate
from polydraulic._kernel import driver
from polydraulic.errors import InputError
from polydraulic.export.machine import export_machine, export_name, machine_c, machine_parts
from polydraulic.machine.frames import link_frames, placed
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.operator import random_signals
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.simulation.steps import DIVERGED
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of, with_pumps

SCENARIOS = ("sine", "step", "pulse", "task")
PLACES = {name: place for place, (name, _) in enumerate(machine_parts("cat215b", "exact").outputs)}
BAD_INPUT = 8
# plain Python has the bits of compiled code over whole scenarios elsewhere, and makes steps slowly
END, STEPS = ({"t_end": 3.0}, 600) if numba.config.DISABLE_JIT else ({}, 3000)


def limited(machine):
    return with_pumps(machine, torque_limit_enabled=True)


def same_bits(a, b):
    return np.array_equal(np.ascontiguousarray(a).view(np.int64), np.ascontiguousarray(b).view(np.int64))


def assert_equal_runs(machine, flow, voltage, folder, *, locked=(), **more):
    """C and the compiled loop over the same voltages; returns the rows."""
    rows, counts = stepped(machine, flow, voltage, locked)
    found, status = c_machine.CMachine(machine, flow, folder, locked=locked, **more).run(voltage)
    assert same_bits(found[:, :-3], rows)
    tips = placed(link_frames(machine, rows[:, 9:12]), *machine.tip)
    assert np.abs(found[:, -3:] - tips).max() < 1e-12
    assert np.count_nonzero(status[1:] == 2) == counts[1]
    return found


def operator_voltages(n, seed):
    signals = random_signals(seed, n * 5e-3, links=LINKS, limit=5.0, functions=LINKS)
    return np.column_stack([signals[link](np.arange(n) * 5e-3) for link in LINKS])


@pytest.mark.parametrize(
    ("flow", "name"),
    [("exact", name) for name in SCENARIOS]
    + [pytest.param("polynomial", name, marks=[pytest.mark.slow] if name != "task" else []) for name in SCENARIOS],
)
def test_all_scenarios_give_the_bits_of_simulate(machine, flow, name, tmp_path):
    scenario = load_scenario(name)
    table = simulate(machine, flow, scenario, **END)
    own = adapted(machine, scenario)
    voltage = step_inputs(own, scenario, np.arange(table.info["steps"]) * 5e-3)
    found, status = c_machine.CMachine(own, flow, tmp_path, locked=scenario.locked).run(voltage)
    compared = [name for name in PLACES if name in table.names]
    assert len(compared) >= 24
    for column in compared:
        if column.startswith("effector"):  # the tip follows from the angles by other arithmetic
            assert np.abs(found[:, PLACES[column]] - table[column]).max() < 1e-12
        else:
            assert same_bits(found[:, PLACES[column]], table[column]), column
    assert np.count_nonzero(status[1:] == 2) == table.info["steps_out_of_domain"]


@pytest.mark.parametrize("flow", ["exact", "polynomial"])
def test_a_random_operator_gives_the_same_bits(machine, flow, tmp_path):
    assert_equal_runs(machine, flow, operator_voltages(STEPS, 11), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("optimise", ["-O0", "-O3"])
@pytest.mark.parametrize("flow", ["exact", "exact with torque limit", "polynomial"])
def test_100_000_steps_of_a_random_operator(machine, flow, optimise, tmp_path):
    chosen = limited(machine) if "limit" in flow else machine
    rows = assert_equal_runs(chosen, flow.split()[0], operator_voltages(100_000, 5), tmp_path, optimise=optimise)
    stops = [machine.function(link).stops for link in LINKS]
    assert all(np.any((rows[:, 9 + i] == s.low) | (rows[:, 9 + i] == s.high)) for i, s in enumerate(stops) if i)
    if flow == "exact":
        assert np.any(rows[:, PLACES["boom.q_relief"]] > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("flow", ["polynomial-fine", "neural", "iterative", "stiff", "tlm"])
def test_other_flow_models_translate_too(machine, flow, tmp_path):
    assert_equal_runs(machine, flow, operator_voltages(20_000, 3), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("flow", ["exact", "polynomial"])
def test_100_000_random_states_step_to_the_same_bits(machine, flow, tmp_path):
    rng, n = np.random.default_rng(8), 100_000
    travel, relief = spool_of(machine).end, 1.1 * pump_of(machine, "boom").relief
    low = [*[-travel] * 3, *[0.0] * 6, -3.0, -1.0, -3.0, *[-3.0] * 3]
    high = [*[travel] * 3, *[relief] * 6, 3.0, 1.5, 0.0, *[3.0] * 3]
    rows = np.zeros((n, len(PLACES)))
    rows[:, :15] = rng.uniform(low, high, (n, 15))
    rows[rng.random(rows.shape) < 0.05] = 0.0
    voltage, status = rng.uniform(-6.0, 6.0, (n, 3)), np.zeros(n, dtype=np.int64)
    parts, expected = machine_parts(machine, flow), rows.copy()
    advance = parts.advance

    @driver
    def each(machine, memory, rows, voltage, status):
        for i in range(rows.shape[0]):
            memory[:] = 0.0
            status[i] = advance(machine, memory, rows[i], voltage[i])

    each(parts.numbers, np.zeros(parts.n_memory), expected, voltage, status)
    c = c_machine.CMachine(machine, flow, tmp_path)
    c.init()
    for i in range(n):
        c.out[:] = rows[i]
        assert c.step(voltage[i]) == status[i]
        rows[i] = c.out
    assert same_bits(rows, expected)


def test_any_communication_step_makes_the_same_steps(machine, tmp_path):
    c = c_machine.CMachine(machine, "exact", tmp_path)
    voltage = np.array([1.0, -2.0, 3.0])
    rows, _ = c.run(np.tile(voltage, (40, 1)))
    for duration, count in ((0.002, 100), (0.05, 4), (0.2, 1), (0.2 / 7, 7), (1e-4, 2000)):
        c.init()
        for _ in range(count):
            assert c.advance(voltage, duration) == 0
        assert c.struct.steps == 40
        assert abs(c.struct.rest) < 1e-10
        assert same_bits(c.out, rows[-1])


def test_what_is_not_finite_is_refused_and_changes_nothing(machine, tmp_path):
    c = c_machine.CMachine(machine, "exact", tmp_path)
    c.init()
    before = bytes(c.struct)
    assert c.step([0.0, np.nan, 0.0]) == BAD_INPUT
    assert c.step([np.inf, 0.0, 0.0]) == BAD_INPUT
    for duration in (np.nan, np.inf, -0.1, 1e8):
        assert c.advance([0.0, 0.0, 0.0], duration) == BAD_INPUT
    assert bytes(c.struct) == before


def test_a_machine_that_leaves_all_reason_stays_where_it_was(machine, tmp_path):
    c = c_machine.CMachine(machine, "exact", tmp_path)
    c.init()
    c.out[PLACES["swing.rate"]] = np.nan
    before = c.out.copy()
    assert c.step([0.0, 0.0, 0.0]) == DIVERGED
    assert same_bits(c.out, before)


def test_dead_times_delay_the_voltages(machine, tmp_path):
    late = changed(machine, "boom", pilot={"dead_time": 0.02})
    voltage = operator_voltages(200, 2)
    delayed = voltage.copy()
    delayed[:4, 1], delayed[4:, 1] = 0.0, voltage[:-4, 1]
    found, _ = c_machine.CMachine(late, "exact", tmp_path / "late").run(voltage)
    expected, _ = c_machine.CMachine(machine, "exact", tmp_path / "now").run(delayed)
    assert same_bits(found, expected)


def test_locked_joints_ignore_their_voltages(machine, tmp_path):
    c = c_machine.CMachine(machine, "exact", tmp_path, locked=("swing", "stick"))
    rows, _ = c.run(np.full((100, 3), 4.0))
    assert np.ptp(rows[:, PLACES["boom.angle"]]) > 0.01
    assert np.ptp(rows[:, [PLACES["swing.angle"], PLACES["stick.angle"], PLACES["stick.spool"]]], axis=0).max() == 0.0


MAIN = """
#include "m.h"
#include <math.h>

int main(void)
{
    m_machine m;
    m_init(&m);
    for (int k = 0; k < 4000; k++) {
        const double voltage[3] = {5.0 * sin(0.01 * k), 5.0 * cos(0.007 * k), (k % 400 < 200) ? 4.0 : -4.0};
        m_step(&m, voltage);
    }
    const double bad[3] = {NAN, 0.0, 1e300};
    m_step(&m, bad);
    const double huge[3] = {-1e308, 1e308, 1e308};
    m_advance(&m, huge, 0.5);
    m.out[M_BOOM_P_A] = 1e300;
    m_step(&m, huge);
    return isfinite(m.out[M_BOOM_ANGLE]) ? 0 : 1;
}
"""


@pytest.mark.slow
@pytest.mark.parametrize("flow", ["exact", "polynomial"])
def test_sanitizers_find_nothing(machine, flow, tmp_path):
    files = machine_c(machine, flow, name="m") | {"main.c": MAIN}
    flags = "-g -O1 -fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero -fno-sanitize-recover=all"
    program = c_machine.compiled(files, tmp_path, *flags.split())
    done = subprocess.run([str(program)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_header_is_c_plus_plus_and_the_code_is_plain(machine, tmp_path):
    paths = export_machine(machine, "polynomial", tmp_path, name="digger")
    assert sorted(path.name for path in paths) == sorted(path.name for path in tmp_path.iterdir())
    text = "".join(path.read_text() for path in paths)
    for word in ("malloc", "stdio", "goto", "while"):
        assert word not in text
    assert "DIGGER_BOOM_ANGLE = 10, /* rad */" in text
    if shutil.which("g++"):
        use = '#include "digger.h"\nint f(digger_machine *m) { return digger_init(m) + DIGGER_BOOM_ANGLE; }\n'
        (tmp_path / "use.cpp").write_text(use)
        command = ["g++", "-std=c++11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only", "use.cpp"]
        subprocess.run(command, check=True, cwd=tmp_path)


@pytest.mark.parametrize(
    ("flow", "options", "match"),
    [
        ("exact", {"name": "my machine"}, "must be a C identifier, for example 'my_machine'"),
        ("exact", {"locked": ("arm",)}, "'arm' is not a function of the machine"),
        ("exact", {"dt": 0.0}, "dt = 0.0 s"),
        ("none", {}, "unknown flow model 'none'"),
    ],
)
def test_bad_input_is_named(machine, flow, options, match):
    with pytest.raises(InputError, match=match):
        machine_c(machine, flow, **options)


def test_the_name_of_a_machine_may_be_part_of_those_of_kernels(machine, tmp_path):
    files = machine_c(machine, "exact", name="machine")
    assert "static inline Step " in files["machine_kernels.c"]
    c_machine.compiled(files, tmp_path, "-shared", "-fPIC")


def test_the_name_of_an_export_is_that_of_the_machine_it_came_from(machine):
    assert export_name("loader_crane") == "loader_crane"
    assert export_name("some/where/my crane.v2.toml") == "my_crane_v2"
    assert export_name("int.toml") == "int_"
    assert export_name(machine) == "machine"
    assert "cat215b.h" in machine_c("cat215b", "exact")


def test_tables_that_are_too_large_for_a_c_file_are_refused(machine):
    with pytest.raises(
        InputError, match=r"flow 'polynomial' holds \d+ numbers; a C file takes up to 100: learn networks"
    ):
        machine_c(machine, "polynomial", most_numbers=100)
