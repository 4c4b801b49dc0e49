"""The mechanics of trees against MuJoCo, energies and finite differences; one text for numba, Python and C."""

import numpy as np
import pytest

from helpers.trees import GRAVITY, TREES, mechanics, mujoco_model, random_states
from polydraulic.machine.tree.motion_text import moving


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("mechanics")


@pytest.fixture(scope="module", params=TREES)
def tree(request, folder):
    links = TREES[request.param]
    module = mechanics(folder, links, points=[link.name for link in links])
    return links, module, module.prepare_motion(links, GRAVITY)


def accelerations(module, constants, states, held=None):
    found = np.empty_like(states[0])
    held = held or module.Held(*[False] * found.shape[1])
    module.accelerate(*states, held, constants, found)
    return found


def test_accelerations_are_those_of_mujoco(tree):
    mujoco = pytest.importorskip("mujoco")
    links, module, constants = tree
    model = mujoco_model(links)
    data, states = mujoco.MjData(model), random_states(links, 2000)
    found = accelerations(module, constants, states)
    worst = 0.0
    for q, v, torque, mine in zip(*states, found, strict=True):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, v, torque
        mujoco.mj_forward(model, data)
        worst = max(worst, np.max(np.abs(mine - data.qacc)) / np.max(np.abs(data.qacc)))
    print(len(moving(links)), worst)
    assert worst < 1e-10
