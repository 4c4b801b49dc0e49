import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.machine.frames import link_frames, placed


def test_a_crane_by_hand(tmp_path):
    crane = load_machine(write_crane(tmp_path))
    slew, lift, out = 0.7, 0.4, 0.9
    reach = 0.1 + (1.8 + out + 1.5) * np.cos(lift)
    tip = placed(link_frames(crane, np.array([slew, lift, out])), *crane.tip)
    assert tip == pytest.approx([reach * np.cos(slew), reach * np.sin(slew), 1.5 + (1.8 + out + 1.5) * np.sin(lift)])


def test_an_excavator_reaches_where_its_closed_form_says():
    machine = load_machine("cat215b")
    swing, boom, stick = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 50))
    frames = link_frames(machine, np.column_stack([swing, boom, stick]))
    foot, boom_length, stick_length = machine.link("boom").at, machine.link("stick").at["x"], machine.tip[1]["x"]
    reach = foot["x"] + boom_length * np.cos(boom) + stick_length * np.cos(boom + stick)
    x, y = reach * np.cos(swing) - foot["y"] * np.sin(swing), reach * np.sin(swing) + foot["y"] * np.cos(swing)
    z = boom_length * np.sin(boom) + stick_length * np.sin(boom + stick)
    assert np.allclose(placed(frames, *machine.tip), np.column_stack([x, y, z]), atol=1e-12)
    turn, _ = frames["stick"]
    assert np.allclose(turn @ np.swapaxes(turn, -1, -2), np.eye(3), atol=1e-14)
