"""The mechanics of trees against MuJoCo, energies and finite differences; one text for numba, Python and C."""

import ast
import ctypes
import os
import re
import subprocess
import sys
from typing import NamedTuple

import numba
import numpy as np
import pytest

from helpers.kernels_in_c import library
from helpers.trees import (
    GRAVITY,
    TREES,
    everything,
    excavator,
    loaded,
    mass_entries,
    mechanics,
    mujoco_model,
    random_states,
    random_tree,
)
from polydraulic import _kernel
from polydraulic.errors import InputError
from polydraulic.machine.tree.links import MAX_LINKS, Link
from polydraulic.machine.tree.motion_text import MOTION_IMPORTS, motion_text, moving

N = 2000


class Tree(NamedTuple):
    links: list
    columns: list
    module: object
    plain: object
    constants: np.ndarray
    states: tuple
    point: np.ndarray
    found: np.ndarray


def evaluated(module, tree_columns, constants, states, point, held=None):
    """All columns at many states, one a row."""
    q = states[0]
    found = np.zeros((len(q), len(tree_columns)))
    module.evaluate_all(*states, np.zeros_like(q) if held is None else held, point, constants, found)
    return found


def at(tree, states, held=None):
    return evaluated(tree.module, tree.columns, tree.constants, states, tree.point[: len(states[0])], held)


def part(tree, found, prefix):
    """Columns that begin so."""
    return found[:, [i for i, column in enumerate(tree.columns) if column.startswith(f"{prefix}.")]]


def matrices(tree, found):
    n = len(moving(tree.links))
    result = np.zeros((len(found), n, n))
    for field, (i, j) in mass_entries(tree.links).items():
        result[:, i, j] = result[:, j, i] = found[:, tree.columns.index(f"m.mass.{field}")]
    return result


SLOW = {"six links", "branches"}  # compile for long


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in TREES],
)
def tree(request, tmp_path_factory):
    links, folder = TREES[request.param], tmp_path_factory.mktemp("mechanics")
    columns, text = everything(links)
    module, plain = (mechanics(folder, links, [links[-1].name], text, plain=plain) for plain in (False, True))
    constants = np.array(module.prepare_motion(links, GRAVITY))
    states = random_states(links, N)
    point = np.random.default_rng(5).uniform(-1.0, 1.0, (N, 6)) * ([1.0] * 3 + [1e4] * 3)
    found = evaluated(module, columns, constants, states, point)
    return Tree(links, columns, module, plain, constants, states, point, found)


@pytest.fixture(scope="module")
def seen(tree):
    """What MuJoCo finds, in the order of the columns of what it knows."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco_model(tree.links)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data, n = mujoco.MjData(model), model.nv
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, tree.links[-1].name)
    found = {key: [] for key in ("mass", "rest", "a", "place", "push", "height", "motion_energy")}
    dense, push = np.zeros((n, n)), np.zeros(n)
    for q, v, torque, point in zip(*tree.states, tree.point, strict=True):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, v, torque
        mujoco.mj_forward(model, data)
        place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ point[:3]
        push[:] = 0.0
        mujoco.mj_applyFT(model, data, point[3:], np.zeros(3), place, body, push)
        mujoco.mj_fullM(model, data, dense)
        for key, value in (
            ("mass", dense),
            ("rest", data.qfrc_bias),
            ("a", data.qacc),
            ("place", place),
            ("push", push),
            ("height", data.energy[0]),
            ("motion_energy", data.energy[1]),
        ):
            found[key].append(np.array(value))
    return {key: np.array(values) for key, values in found.items()}


def worst(mine, theirs):
    """Largest difference relative to the largest entry of its row."""
    mine, theirs = mine.reshape(len(mine), -1), theirs.reshape(len(theirs), -1)
    return np.max(np.max(np.abs(mine - theirs), axis=1) / np.max(np.abs(theirs), axis=1))


def test_accelerations_are_those_of_mujoco(tree, seen):
    assert worst(part(tree, tree.found, "a"), seen["a"]) < 1e-10


def test_mass_matrix_and_torques_of_motion_are_those_of_mujoco(tree, seen):
    assert worst(matrices(tree, tree.found), seen["mass"]) < 1e-12
    mine = part(tree, tree.found, "m.bias") + part(tree, tree.found, "m.gravity")
    assert worst(mine, seen["rest"]) < 1e-11


def test_points_and_forces_at_them_are_those_of_mujoco(tree, seen):
    assert np.max(np.abs(part(tree, tree.found, "place") - seen["place"])) < 1e-13
    assert worst(part(tree, tree.found, "push"), seen["push"]) < 1e-12


def test_energies_are_those_of_mujoco(tree, seen):
    scale = np.max(np.abs(seen["height"]))
    assert np.max(np.abs(tree.found[:, tree.columns.index("height")] - seen["height"])) < 1e-13 * scale
    mine = tree.found[:, tree.columns.index("motion_energy")]
    assert np.max(np.abs(mine / seen["motion_energy"] - 1.0)) < 1e-12


def test_gravity_is_the_slope_of_the_potential_energy(tree):
    q, v, torque = (values[:50] for values in tree.states)
    for joint in range(q.shape[1]):
        step = np.zeros(q.shape[1])
        step[joint] = 1e-5
        high, low = (at(tree, (q + sign * step, v, torque))[:, tree.columns.index("height")] for sign in (1.0, -1.0))
        mine = part(tree, tree.found[:50], "m.gravity")[:, joint]
        assert mine == pytest.approx((high - low) / 2e-5, rel=1e-7, abs=1e-3)


def test_a_force_does_the_work_that_its_torques_do(tree):
    """Torques of a force are its components along the slopes of the place of its point."""
    q, v, torque = (values[:50] for values in tree.states)
    for joint in range(q.shape[1]):
        step = np.zeros(q.shape[1])
        step[joint] = 1e-5
        high, low = (part(tree, at(tree, (q + sign * step, v, torque)), "place") for sign in (1.0, -1.0))
        work = np.sum((high - low) / 2e-5 * tree.point[:50, 3:], axis=1)
        assert part(tree, tree.found[:50], "push")[:, joint] == pytest.approx(work, rel=1e-7, abs=1e-3)


def test_motion_alone_keeps_the_kinetic_energy(tree):
    """Without torques the bias must only turn energy around: d(v M v / 2)/dt = 0, with dM/dt by differences."""
    q, v, torque = (values[:50] for values in tree.states)
    high, low = (matrices(tree, at(tree, (q + sign * 1e-6 * v, v, torque))) for sign in (1.0, -1.0))
    rise = 0.5 * np.einsum("ki,kij,kj->k", v, (high - low) / 2e-6, v)
    power = np.sum(v * part(tree, tree.found[:50], "m.bias"), axis=1)
    assert power == pytest.approx(rise, rel=1e-6, abs=1e-3)


def test_held_joints_leave_the_reduced_system(tree):
    rng, (q, v, torque) = np.random.default_rng(6), (values[:200] for values in tree.states)
    held = rng.integers(0, 2, q.shape).astype(float)
    held[0], held[1] = 0.0, 1.0
    found = at(tree, (q, v, torque), held)
    mass, mine = matrices(tree, found), part(tree, found, "a")
    right = torque - part(tree, found, "m.bias") - part(tree, found, "m.gravity")
    for k in range(len(q)):
        free = held[k] == 0.0
        assert np.all(mine[k][~free] == 0.0)
        expected = np.linalg.solve(mass[k][np.ix_(free, free)], right[k][free])
        assert mine[k][free] == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.max(np.abs(expected), initial=0.0))
    assert part(tree, found, "p") == pytest.approx(np.einsum("kij,kj->ki", mass, v), rel=1e-12, abs=1e-9)


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
def test_compiled_and_plain_python_have_equal_bits(tree):
    states = tuple(values[:300] for values in tree.states)
    plain = evaluated(tree.plain, tree.columns, tree.constants, states, tree.point[:300])
    assert np.array_equal(plain.view(np.int64), tree.found[:300].view(np.int64))


def test_c_has_the_same_bits(tree, tmp_path):
    """The kernels translate as they are."""
    n, columns = len(moving(tree.links)), len(tree.columns)
    found, states = np.zeros((300, columns)), [values[:300] for values in tree.states]
    held = np.zeros(n)
    rows = [*states, np.broadcast_to(held, (300, n)).copy(), tree.point[:300]]
    example = [*(row[0] for row in rows), tree.constants, found[0]]
    c, text = library(tmp_path, (tree.module.evaluate, example))
    assert "static inline Motion motion(" in text
    address = ctypes.c_void_p(tree.constants.ctypes.data)
    for k in range(300):
        c.evaluate(
            *(ctypes.c_void_p(row[k].ctypes.data) for row in rows), address, ctypes.c_void_p(found[k].ctypes.data)
        )
    assert np.array_equal(found.view(np.int64), tree.found[:300].view(np.int64))


def compared_with_mujoco(links, folder, n):
    """Largest errors of accelerations and places of `links`, not compiled, relative to the largest of each state."""
    mujoco = pytest.importorskip("mujoco")
    columns, text = everything(links)
    module, model = mechanics(folder, links, [links[-1].name], text, plain=True), mujoco_model(links)
    data, states, point = mujoco.MjData(model), random_states(links, n), np.ones((n, 6))
    found = evaluated(module, columns, np.array(module.prepare_motion(links, GRAVITY)), states, point)
    order = [int(model.joint(name).dofadr[0]) for name in moving(links)]  # MuJoCo goes branch by branch
    a, place = ([i for i, column in enumerate(columns) if column.startswith(start)] for start in ("a.", "place."))
    errors = []
    for row, q, v, torque in zip(found, *states, strict=True):
        data.qpos[order], data.qvel[order], data.qfrc_applied[order] = q, v, torque
        mujoco.mj_forward(model, data)
        body = data.body(links[-1].name)
        there = body.xpos + body.xmat.reshape(3, 3) @ point[0, :3]
        errors.append(np.max(np.abs(row[a] - data.qacc[order])) / np.max(np.abs(data.qacc)))
        errors.append(np.max(np.abs(row[place] - there)))
    return max(errors)


@pytest.mark.parametrize("seed", range(30))
def test_any_tree_moves_as_in_mujoco(seed, tmp_path):
    assert compared_with_mujoco(random_tree(seed), tmp_path, 20) < 1e-10


def test_the_longest_chains_move_as_in_mujoco(tmp_path):
    """In one plane, where digits are lost most, the error stays that of the mass matrix' condition."""
    assert compared_with_mujoco(longest(), tmp_path, 50) < 1e-10
    plane = [link._replace(axis="y") for link in longest()]
    assert compared_with_mujoco(plane, tmp_path, 50) < 1e-9


def test_constants_are_floats_of_numbers_of_any_kind():
    links = [Link("arm", None, "revolute", "y", {}, 2, {"x": 1}, {"yy": 1})]
    names: dict[str, object] = {}
    exec("\n".join(MOTION_IMPORTS), names)
    text = motion_text(links)
    assert "stick" not in text
    module_text = text.partition("class Turns")[0]
    exec(module_text, names)
    constants = names["prepare_motion"](links, 10)
    assert all(type(value) is float for value in constants)
    assert dict(constants._asdict())["arm_polar"] == 3.0


def operations(source, name):
    """Number of arithmetic operations in a function."""
    (function,) = (n for n in ast.parse(source).body if isinstance(n, ast.FunctionDef) and n.name == name)
    kinds = [type(node.op) for node in ast.walk(function) if isinstance(node, ast.BinOp)]
    return {kind.__name__: kinds.count(kind) for kind in (ast.Mult, ast.Add, ast.Sub, ast.Div)}


def test_what_is_zero_by_structure_costs_nothing():
    """An excavator takes no more operations than its equations did that were written by hand, for swing, boom and stick."""
    text = motion_text(excavator())
    for name, by_hand in (("motion", 109), ("solve_motion", 42)):
        assert sum(operations(text, name).values()) <= by_hand
    body = text.partition("def motion(")[2].partition("return")[0]
    assert not re.search(r"\b[01]\.0\b", body)


def test_an_arm_in_a_plane_needs_its_plane_alone():
    plane = [
        Link("boom", None, "revolute", "-y", {"x": 0.5}, 100.0, {"x": 1.0}, {"yy": 40.0}),
        Link("stick", "boom", "revolute", "-y", {"x": 2.0}, 50.0, {"x": 0.5}, {"yy": 10.0}),
    ]
    text = motion_text(plane)
    assert operations(text, "motion") == {"Mult": 26, "Add": 7, "Sub": 3, "Div": 0}
    constants = text.partition("class Constants")[2].partition("def ")[0]
    assert "xx" not in constants


def test_a_declared_zero_stays_and_numbers_do_not_enter():
    text = motion_text(excavator())
    other = [link._replace(at=dict.fromkeys(link.at, 0.0), mass=link.mass and 1.0) for link in excavator()]
    assert motion_text(other) == text
    assert motion_text([link._replace(at={}) for link in other]) != text


def test_the_text_is_the_same_in_every_process():
    code = "from helpers.trees import TREES, motion_text; print(*[motion_text(t, points=[t[-1].name]) for t in TREES.values()])"
    texts = {
        subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        ).stdout
        for seed in ("1", "2")
    }
    assert texts == {" ".join(motion_text(t, points=[t[-1].name]) for t in TREES.values()) + "\n"}


def longest():
    """As many links as there may be, about all axes."""
    axes = ("z", "-y", "y", "x", "-y", "-z")
    return [
        Link(f"link_{i}", f"link_{i - 1}" if i else None, "revolute", axes[i % 6], {"x": 1.0}, 1.0, {"x": 0.5},
             {"xx": 1.0, "yy": 1.0, "zz": 1.0})
        for i in range(MAX_LINKS)
    ]  # fmt: skip


@pytest.mark.parametrize("links", [*TREES.values(), longest()], ids=[*TREES, "longest"])
def test_the_text_is_for_people_too(links):
    text = motion_text(links, points=[links[-1].name])
    assert max(map(len, text.splitlines())) <= 120
    assert not re.search(r"[ \t]$", text, re.MULTILINE)
    names = re.findall(r"^    (\w+) =", text.partition("def motion(")[2].partition("\n@kernel")[0], re.MULTILINE)
    assert len(names) == len(set(names))
    compile(text, "text", "exec")


def test_a_longest_chain_has_two_digits_in_its_mass_matrix():
    assert "m1_12: float  # link_0, link_11" in motion_text(longest())


def test_wrong_links_are_refused(tmp_path):
    links = excavator()
    module = mechanics(tmp_path, links, plain=True)
    with pytest.raises(InputError, match="written for"):
        module.prepare_motion([link._replace(at={}) for link in links], GRAVITY)
    with pytest.raises(InputError, match="2 links for equations of motion of 3"):
        module.prepare_motion(links[:2], GRAVITY)
    with pytest.raises(InputError, match="links are swing, boom, stick"):
        motion_text(links, points=["bucket"])


LANES = '''

@driver
def lanes(rows, held, constants):
    """Angles, rates and torques of 64 machines to their accelerations."""
    for lane in range(64):
        turn = turns(Joints(rows[lane], rows[64 + lane], rows[128 + lane], rows[192 + lane]))
        rate = Joints(rows[256 + lane], rows[320 + lane], rows[384 + lane], rows[448 + lane])
        m = motion(turn, rate, constants)
        right = Joints(
            rows[512 + lane] - m.bias.swing - m.gravity.swing,
            rows[576 + lane] - m.bias.boom - m.gravity.boom,
            rows[640 + lane] - m.bias.stick - m.gravity.stick,
            rows[704 + lane] - m.bias.bucket - m.gravity.bucket,
        )
        a = solve_motion(m.mass, held, right)
        rows[768 + lane], rows[832 + lane], rows[896 + lane], rows[960 + lane] = a.swing, a.boom, a.stick, a.bucket
'''


@pytest.mark.slow
@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
def test_lanes_are_vector_instructions(tmp_path):
    links = excavator(4)
    module = mechanics(tmp_path, links, more=LANES)
    fresh = numba.njit(**_kernel._DRIVER_OPTIONS)(module.lanes.py_func)
    fresh(np.ones(1024), module.Held(False, False, False, False), module.prepare_motion(links, GRAVITY))
    assembly = fresh.inspect_asm(fresh.signatures[0])
    if not re.search(r"\bvmovupd\b", assembly):
        pytest.skip("this processor has no AVX")
    packed, scalar = (len(re.findall(rf"\tv(?:mul|add|sub|div){kind}\t", assembly)) for kind in ("pd", "sd"))
    assert packed > 150
    assert scalar == 0


def test_a_file_with_the_text_is_what_its_imports_say(tmp_path):
    """Nothing else is needed at the top of the file."""
    links = excavator(2)
    joints = "class Joints(NamedTuple):\n    swing: float\n    boom: float\n\n\n"
    module = loaded(tmp_path, "\n".join(MOTION_IMPORTS) + f"\n\n\n{joints}{motion_text(links)}")
    assert module.Joints._fields == ("swing", "boom")
    assert module.prepare_motion(links, GRAVITY).gravity == GRAVITY
