"""Levers move the right function the right way."""

import numpy as np
import pytest

from polydraulic import InputError, Simulator, load_machine
from polydraulic.control import lever_pattern
from polydraulic.control.lever_patterns import STICKS
from polydraulic.simulation.input_check import full_lever

ISO = {
    ("left_x", 1): ("swing", "swing right"),
    ("left_y", 1): ("stick", "stick out"),
    ("right_x", 1): ("bucket", "bucket dump"),
    ("right_y", 1): ("boom", "boom down"),
}
EXPECTED = {  # machine: (stick, function, sign of the voltage with the stick to the right or forward)
    "excavator_22t": [("left_x", "swing", -1), ("right_y", "boom", -1), ("left_y", "stick", 1), ("right_x", "bucket", 1)],
    "cat215b": [("left_x", "swing", -1), ("right_y", "boom", -1), ("left_y", "stick", 1)],
    "wheel_loader": [("right_y", "lift", -1), ("right_x", "tilt", -1)],
    "loader_crane": [
        ("left_x", "slew", -1), ("right_y", "inner", -1), ("left_y", "outer", 1), ("extra_y", "reach", 1), ("right_x", "tilt", 1),
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", [*EXPECTED, "cat215b_bucket", "cat215b_crossover"])
def test_each_function_has_the_stick_and_the_sign_of_the_iso_pattern(name: str) -> None:
    pattern = lever_pattern(name, "iso")
    found = [(a.stick, a.function, a.sign) for a in pattern.axes]
    expected = EXPECTED.get(name) or EXPECTED["excavator_22t"]
    assert found == expected


def test_sae_changes_boom_and_stick_and_nothing_else() -> None:
    iso, sae = (lever_pattern("excavator_22t", name) for name in ("iso", "sae"))
    assert [(a.stick, a.positive) for a in iso.axes] == [
        ("left_x", "swing right"), ("right_y", "boom down"), ("left_y", "stick out"), ("right_x", "bucket dump"),
    ]  # fmt: skip
    assert [(a.stick, a.positive) for a in sae.axes] == [
        ("left_x", "swing right"), ("left_y", "boom down"), ("right_y", "stick out"), ("right_x", "bucket dump"),
    ]  # fmt: skip


def test_a_stick_does_nothing_in_its_dead_zone_and_gives_full_lever_at_its_end() -> None:
    machine = load_machine("cat215b")
    pattern = lever_pattern(machine, "iso", dead_zone=0.1)
    boom = machine.names.index("boom")
    full = full_lever(machine.function("boom"))
    for at, share in ((0.0, 0.0), (0.1, 0.0), (-0.1, 0.0), (0.55, 0.5), (1.0, 1.0), (1.3, 1.0), (-1.0, -1.0)):
        volts = pattern.voltages({"right_y": at})
        assert volts[boom] == pytest.approx(-share * full, abs=1e-12)
        assert np.count_nonzero(volts) == (share != 0.0)
    np.testing.assert_array_equal(pattern.voltages(np.ones(6)), pattern.full)


def test_the_machine_does_what_the_labels_say() -> None:
    moves = {"right_y": ("effector.z", -1), "left_y": ("effector.x", 1), "left_x": ("effector.y", -1)}
    pattern = lever_pattern("cat215b", "iso")
    for stick, (column, sign) in moves.items():
        with Simulator("cat215b") as machine:
            machine.step(np.zeros(3), n=20)
            with Simulator("cat215b") as still:
                still.step(np.zeros(3), n=220)
                machine.step(pattern.voltages({stick: 1.0}), n=200)
                assert sign * (float(machine[column]) - float(still[column])) > 0.05, stick


@pytest.mark.parametrize(
    ("role", "message"),
    [
        ("", "functions.boom does not say what it is"),
        ("stick", "boom and stick would both be moved by left_y"),
        ("swing", "needs a revolute joint about z or -z; that of boom is revolute, about -y"),
        ("extension", "needs a prismatic joint"),
    ],
)
def test_a_machine_that_does_not_say_what_its_functions_are_is_refused(role: str, message: str) -> None:
    machine = load_machine("cat215b")
    functions = tuple(f._replace(role=role) if f.name == "boom" else f for f in machine.functions)
    with pytest.raises(InputError, match=message):
        lever_pattern(machine._replace(functions=functions), "iso")


@pytest.mark.parametrize("sticks", [[0.0] * 5, [0.0] * 5 + [np.nan], "left", {"left": 1.0}, [[0.0] * 6], None])
def test_sticks_that_are_no_positions_are_refused(sticks: object) -> None:
    with pytest.raises(InputError, match="stick"):
        lever_pattern("cat215b", "iso").voltages(sticks)


@pytest.mark.parametrize(("name", "dead_zone"), [("din", 0.05), ("iso", 0.95), ("iso", -0.1), ("iso", "little")])
def test_patterns_and_dead_zones_that_there_are_not_are_refused(name: str, dead_zone: object) -> None:
    with pytest.raises(InputError, match="must be"):
        lever_pattern("cat215b", name, dead_zone=dead_zone)  # type: ignore[arg-type]


def test_every_stick_has_a_name_of_its_own() -> None:
    assert len(set(STICKS)) == 6
