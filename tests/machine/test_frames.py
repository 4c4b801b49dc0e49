import numpy as np
import pytest
from polydraulic.machine.linkage import end_effector

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.machine.frames import link_frames, placed


def test_a_crane_by_hand(tmp_path):
    crane = load_machine(write_crane(tmp_path))
    slew, lift, out = 0.7, 0.4, 0.9
    reach = 0.1 + (1.8 + out + 1.5) * np.cos(lift)
    tip = placed(link_frames(crane, np.array([slew, lift, out])), *crane.tip)
    assert tip == pytest.approx([reach * np.cos(slew), reach * np.sin(slew), 1.5 + (1.8 + out + 1.5) * np.sin(lift)])


def test_the_excavator_as_a_tree_reaches_where_its_closed_form_says():
    tree, arm = load_machine("cat215b_bucket"), load_machine("cat215b")
    angles = np.random.default_rng(1).uniform(-1.5, 1.5, (50, 4))
    found = placed(link_frames(tree, angles), "stick", tree.link("bucket").at)
    assert np.allclose(found, end_effector(angles[:, :3], arm.geometry), atol=1e-9)
    turn, _ = link_frames(tree, angles)["bucket"]
    assert np.allclose(turn @ np.swapaxes(turn, -1, -2), np.eye(3), atol=1e-14)
