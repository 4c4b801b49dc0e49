"""Steps beyond what the log of an identified machine had are counted, and said."""

import numpy as np
import pytest

from helpers.held_levers import held_scenario, random_levers
from polydraulic import InputError, Simulator, load_machine, random_operator, simulate
from polydraulic.parameters.layout.parts import Seen
from polydraulic.simulation.summary import warnings

SCENARIO = random_operator(3, 4.0, limit=1.0)


def identified(machine, seen):
    return machine._replace(
        functions=tuple(f._replace(seen=seen if f.name == "boom" else None) for f in machine.functions)
    )


def test_travel_and_pressure_beyond_the_log_are_counted(machine):
    plain = simulate(machine, "exact", SCENARIO)
    assert "steps_beyond_log" not in plain.info
    spool, p_in = np.abs(plain["boom.spool"]), plain["boom.p_in"]
    opens = machine.function("boom").valve.knots[1]
    travel = float(np.quantile(spool, 0.9))
    pressure = float(np.median(p_in[spool > opens]))
    for seen in (Seen(travel), Seen(1.0, pressure), Seen(travel, pressure)):
        run = simulate(identified(machine, seen), "exact", SCENARIO)
        assert np.array_equal(run["boom.angle"], plain["boom.angle"])
        beyond = (spool > seen.travel) | ((spool > opens) & (p_in > seen.pressure))
        assert run.info["steps_beyond_log"] == run.info["steps_out_of_domain"] == np.count_nonzero(beyond[1:]) > 0
        said = [line for line in warnings(run) if "the log that the machine was identified from" in line]
        assert len(said) == 1
        assert not [line for line in warnings(run) if "held at its border" in line]
    inside = simulate(identified(machine, Seen(1.0)), "exact", SCENARIO)
    assert inside.info["steps_beyond_log"] == 0
    assert not [line for line in warnings(inside) if "identified from" in line]


@pytest.mark.slow_to_compile
def test_methods_with_their_own_steps_count_rows(machine):
    run = simulate(identified(machine, Seen(6e-3)), "exact", SCENARIO, t_end=2.0, method="rosenbrock")
    assert run.info["rows_beyond_log"] == np.count_nonzero(np.abs(run["boom.spool"]) > 6e-3) > 0
    assert any("rows" in line and "identified from" in line for line in warnings(run))


def test_a_simulator_counts_the_same_steps(machine):
    seen = identified(machine, Seen(6e-3, 1e7))
    levers = random_levers(1, 240, 3, limit=1.2, each=40)
    run = simulate(seen, "exact", held_scenario(machine, levers, 5e-3))
    with Simulator(seen) as one:
        for k in range(0, 240, 40):
            one.step(levers[k], n=40)
        assert one["boom.spool"] == run["boom.spool"][-1]
        assert one.steps_beyond_log == one.steps_out_of_domain == run.info["steps_beyond_log"] > 0
        one.reset()
        assert one.steps_beyond_log == 0
        one.change({"functions.boom.valve.knots": machine.function("boom").valve.knots})
        assert one.machine.function("boom").seen == Seen(6e-3, 1e7)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('travel = { value = 11, unit = "mm", source = "log" }', ""),
        ('pressure = { value = 11, unit = "bar", source = "log" }', "functions.boom.seen"),
        ('travel = { value = -1, unit = "mm", source = "log" }', "functions.boom.seen.travel"),
    ],
)
def test_a_file_may_say_what_was_seen(machine, tmp_path, table, words):
    from polydraulic.parameters.load import machine_path

    path = tmp_path / "machine.toml"
    path.write_text(
        machine_path("cat215b").read_text(encoding="utf-8") + f"\n[functions.boom.seen]\n{table}\n", encoding="utf-8"
    )
    if words:
        with pytest.raises(InputError, match=words):
            load_machine(path)
    else:
        assert load_machine(path).function("boom").seen == Seen(0.011)
