"""Poses with the tip at given places: the tip is there, and stops count."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.machine.frames import link_frames, placed
from polydraulic.machine.stability.poses import arm_functions, arm_poses, held_positions

MACHINES = ("cat215b", "excavator_22t", "loader_crane", "wheel_loader")


@pytest.mark.parametrize("name", MACHINES)
def test_the_tip_is_at_its_place_and_every_pose_is_found_again(name):
    machine = load_machine(name)
    pair = arm_functions(machine)
    held = held_positions(machine, {})
    places = [machine.names.index(f.name) for f in pair]
    rng = np.random.default_rng(5)
    poses = np.tile(held, (40, 1))
    for f, place in zip(pair, places, strict=True):
        poses[:, place] = f.stops.low + (f.stops.high - f.stops.low) * rng.random(40)
    poses[0, places] = [f.stops.high for f in pair]  # at the stops themselves
    if machine.links[0].axis == "z":
        poses[:, 0] = 0.0
    tips = placed(link_frames(machine, poses), *machine.tip)
    found = arm_poses(machine, pair, held, tips[:, [0, 2]])
    for side in (0, 1):
        able = found.possible[side]
        again = placed(link_frames(machine, found.positions[side][able]), *machine.tip)
        np.testing.assert_allclose(again[:, [0, 2]], tips[able][:, [0, 2]], rtol=0, atol=1e-9)
    away = np.where(found.possible, np.abs(found.positions - poses).max(axis=2), np.inf)
    assert away.min(axis=0).max() < 1e-6


def test_places_out_of_reach_have_no_pose():
    machine = load_machine("cat215b")
    pair = arm_functions(machine)
    far = np.array([[20.0, 0.0], [0.81, 0.0]])
    assert not arm_poses(machine, pair, held_positions(machine, {}), far).possible.any()


def test_functions_that_cannot_move_the_tip_in_its_plane_are_refused():
    crane = load_machine("loader_crane")
    assert [f.name for f in arm_functions(crane)] == ["inner", "outer"]
    assert [f.name for f in arm_functions(crane, ("tilt", "inner"))] == ["inner", "tilt"]
    for asked, words in ((("inner", "reach"), "reach: does not turn"), (("inner", "inner"), "two different functions")):
        with pytest.raises(InputError, match=words):
            arm_functions(crane, asked)


def test_held_positions_lie_between_stops():
    crane = load_machine("loader_crane")
    assert held_positions(crane, {"reach": 1.0})[3] == 1.0
    with pytest.raises(InputError, match=r"reach = 2000 mm: beyond its stops, 0 mm to 1700 mm"):
        held_positions(crane, {"reach": 2.0})
    with pytest.raises(InputError, match="not a function"):
        held_positions(crane, {"rich": 1.0})
