"""Dry friction that holds joints: found from what they carry at rest, named where nobody asked, and not found where joints creep."""

from functools import cache

import pytest

from helpers.machine_log import machine_log
from polydraulic import InputError, load_machine, random_operator, simulate
from polydraulic.identification import identify
from polydraulic.identification.equations.mechanics.resting import at_rest
from polydraulic.tables import Table

MACHINE = load_machine("cat215b")
STICKS = "functions.*.friction.sticks"
PILOTS = "functions.*.pilot.*"


@cache
def log(sticks):
    """Two minutes of positions and pressures, without noise, in rows of 20 ms."""
    functions = tuple(f._replace(effects=f.effects._replace(sticks=sticks)) for f in MACHINE.functions)
    run = simulate(MACHINE._replace(functions=functions), "exact", random_operator(5, 120.0, limit=1.0))
    names = ["time", *(f"{f}.{what}" for f in MACHINE.names for what in ("angle", "p_a", "p_b", "voltage", "spool"))]
    return Table({name: run[name][::4] for name in names}, {name: run.unit(name) for name in names})


@pytest.mark.parametrize("sticks", [False, True])
def test_what_joints_carry_at_rest_tells_whether_friction_holds_them(sticks):
    found = at_rest(MACHINE, log(sticks))
    assert found
    for name, rest in found.items():
        coulomb = MACHINE.function(name).friction.coulomb
        assert rest.holds == sticks
        assert rest.coulomb == pytest.approx(coulomb, rel=0.15)
        assert (rest.torque > 0.25 * coulomb) == sticks


def test_masses_of_the_file_need_not_be_right():
    heavier = MACHINE.with_values(
        {f"links.{link.name}.mass": 1.3 * link.mass for link in MACHINE.links if link.mass > 0.0}
    )
    assert {name: rest.holds for name, rest in at_rest(heavier, log(True)).items()} == {
        name: rest.holds for name, rest in at_rest(MACHINE, log(True)).items()
    }


def test_friction_that_holds_is_taken_where_it_is_free(tmp_path):
    found = identify(log(True), MACHINE, free=[STICKS, PILOTS])
    shown = at_rest(MACHINE, log(True))
    for f in found.machine.functions:
        path = f"functions.{f.name}.friction.sticks"
        assert f.effects.sticks == (f.name in shown)
        assert [line for line in (*found.remarks, *found.kept) if line.startswith(f"{path}: ")]
    found.write(tmp_path / "found.toml")
    again = load_machine(tmp_path / "found.toml")
    assert [f.effects.sticks for f in again.functions] == [f.effects.sticks for f in found.machine.functions]


def test_friction_that_holds_and_nobody_asked_for_is_named():
    found = identify(log(True), MACHINE, free=[PILOTS])
    assert not any(f.effects.sticks for f in found.machine.functions)
    for name in at_rest(MACHINE, log(True)):
        (said,) = (line for line in found.remarks if line.startswith(f"dry friction holds the joint of {name}: "))
        assert said.endswith(f"of which the machine knows nothing: free functions.{name}.friction.sticks")


def test_friction_that_lets_joints_creep_is_not_taken():
    sticking = tuple(f._replace(effects=f.effects._replace(sticks=True)) for f in MACHINE.functions)
    found = identify(log(False), MACHINE._replace(functions=sticking), free=[STICKS, PILOTS])
    for name in at_rest(MACHINE, log(False)):
        assert not found.machine.function(name).effects.sticks
        assert [
            line for line in found.kept if line.startswith(f"functions.{name}.friction.sticks: dry friction does not")
        ]
    assert not [line for line in identify(log(False), MACHINE, free=[PILOTS]).remarks if "holds the joint" in line]


def test_a_log_that_does_not_tell_is_named():
    few = Table({name: log(True)[name] for name in log(True).names if name != "boom.p_a"}, log(True).units)
    with pytest.raises(InputError, match=r"functions.boom.friction.sticks: kept; the log has no boom.p_a"):
        identify(few, MACHINE, free=[STICKS])


def test_the_test_log_of_other_tests_creeps():
    assert not any(rest.holds for rest in at_rest(MACHINE, machine_log(120.0)).values())
