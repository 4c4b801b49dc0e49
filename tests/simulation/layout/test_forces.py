"""Forces of actuators and pins: against MuJoCo, whose joints carry what is left beside cylinders, and against weights."""

from dataclasses import replace

import numpy as np
import pytest

from helpers.small_crane import with_effects
from helpers.trees import mujoco_model
from polydraulic import load_machine, simulate
from polydraulic.machine.frames import link_frames, placed
from polydraulic.parameters.layout.geometry import knee_at, lever, rocker
from polydraulic.parameters.layout.parts import FourBar, Pins
from polydraulic.parameters.loads import Loads
from polydraulic.parameters.scenario import Scenario, random_operator
from polydraulic.parameters.schema import Friction
from polydraulic.parameters.signals import Constant, Sine
from polydraulic.simulation.layout.runs import simulate_layout
from polydraulic.simulation.layout.tree import tree_of


def column(run, machine, name, quantity):
    slides = machine.link(machine.function(name).moves).joint == "prismatic"
    words = {"angle": "position", "rate": "speed", "friction_torque": "friction_force"} if slides else {}
    return run[f"{name}.{words.get(quantity, quantity)}"]


def vectors(run, name, quantity):
    return np.column_stack([run[f"{name}.{quantity}_{c}"] for c in "xyz"])


def actuator(machine, f, frames, run, row):
    """Where the force of a cylinder or coupler acts on its link and its parent, and that force; None of a motor."""
    link = machine.link(f.moves)
    if f.actuator == "motor":
        return None
    push = run[f"{f.name}.cylinder_force"][row]
    sign = -1.0 if link.axis[0] == "-" else 1.0
    if f.actuator == "ram":
        there = frames[f.moves][1][0]
        return there, there, push * sign * frames[link.parent][0][0][:, "xyz".index(link.axis[-1])]
    if isinstance(f.pins, Pins):
        base, rod = placed(frames, link.parent, f.pins.base)[0], placed(frames, link.name, f.pins.rod)[0]
        way = (rod - base) / np.linalg.norm(rod - base)
        lengthens = lengthening(machine, f, frames)
        return rod, base, push * (1.0 if lengthens else -1.0) * way
    assert isinstance(f.pins, FourBar)
    assert link.axis == "-y"  # u is along x, v along z
    angle = run[f"{f.name}.angle"][row]
    (u, v), _ = knee_at(rocker(f.pins, link), float(angle))
    turn = frames[link.parent][0]
    joint = frames[link.name][1][0]
    knee = joint + turn[0] @ np.array([u, 0.0, v])
    pin = placed(frames, link.name, f.pins.pin)[0]
    base, hinge = placed(frames, link.parent, f.pins.base)[0], placed(frames, link.parent, f.pins.hinge)[0]
    knee[1] = hinge[1] = base[1] = pin[1] = 0.0
    # the rocker turns freely: what cylinder and coupler do to the knee has no moment about its hinge
    along, coupler = (knee - base) / np.linalg.norm(knee - base), (pin - knee) / np.linalg.norm(pin - knee)
    turns = np.cross(knee - hinge, along)[1], np.cross(knee - hinge, coupler)[1]
    head = f.drive.number * np.pi / 4.0 * f.drive.bore**2
    rod = head - f.drive.number * np.pi / 4.0 * f.drive.rod**2
    p_a, p_b = run[f"{f.name}.p_a"][row], run[f"{f.name}.p_b"][row]
    # the larger area is the head side, which pushes the pins apart
    thrust = head * p_a - rod * p_b if np.isclose(push, head * p_a - rod * p_b) else head * p_b - rod * p_a
    return pin, pin, thrust * turns[0] / turns[1] * coupler


def lengthening(machine, f, frames):
    return lever(f, machine.link(f.moves), 0.5 * (f.stops.low + f.stops.high)) > 0.0


def held_to_mujoco(machine, run, force, rows):
    """Accelerations of MuJoCo with cylinders as outer forces on both links, and what its joints then carry."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco_model(tree_of(machine))
    model.opt.gravity[:] = (0.0, 0.0, -machine.gravity)
    data = mujoco.MjData(model)
    bodies = {f.name: place + 1 for place, f in enumerate(machine.functions)}
    body_of = {f.moves: bodies[f.name] for f in machine.functions} | {"ground": 0}
    worst = 0.0
    for row in rows:
        mujoco.mj_resetData(model, data)
        q = np.array([column(run, machine, f, "angle")[row] for f in machine.names])
        data.qpos[:], data.qvel[:] = q, [column(run, machine, f, "rate")[row] for f in machine.names]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        frames = link_frames(machine, q[None])

        def pushes(body, at, push):
            if body:
                data.xfrc_applied[body, :3] += push
                data.xfrc_applied[body, 3:] += np.cross(at - data.xipos[body], push)

        for place, f in enumerate(machine.functions):
            data.qfrc_applied[place] -= column(run, machine, f.name, "friction_torque")[row]
            acts = actuator(machine, f, frames, run, row)
            if acts is None:
                data.qfrc_applied[place] += run[f"{f.name}.motor_torque"][row]
            else:
                at, other, push = acts
                pushes(bodies[f.name], at, push)
                pushes(body_of[machine.link(f.moves).parent], other, -push)
        pushes(body_of[machine.tip[0]], placed(frames, *machine.tip)[0], force(run["time"][row]))
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        for f in machine.functions:
            carried = data.cfrc_int[bodies[f.name]]
            shift = data.subtree_com[model.body_rootid[bodies[f.name]]] - frames[f.moves][1][0]
            moment = carried[:3] + np.cross(shift, carried[3:])
            ours = vectors(run, f.name, "pin_force")[row], vectors(run, f.name, "pin_moment")[row]
            size = np.abs(data.xfrc_applied).max() + np.abs(carried).max()
            worst = max(worst, np.abs(ours[0] - carried[3:]).max() / size, np.abs(ours[1] - moment).max() / size)
    return worst


@pytest.mark.slow_to_compile
def test_pins_carry_what_the_joints_of_mujoco_do(crane):
    whole = {"xx": 30.0, "yy": 30.0, "zz": 40.0}  # MuJoCo knows no body with less
    crane = crane._replace(links=(crane.links[0]._replace(inertia=whole), *crane.links[1:]))
    operator = random_operator(4, 2.0, functions=crane.names)
    loads = Loads({"y": Sine(300.0, 2.0), "z": Constant(-500.0)})
    scenario = Scenario("pushed", 2.0, operator.voltage, loads=loads)
    run = simulate(crane, "exact", scenario, forces=True)
    assert not [event for event in run.info["events"] if "stop" in event[2]]
    assert np.ptp(run["lift.angle"]) > 0.01
    worst = held_to_mujoco(crane, run, lambda t: loads.forces(np.array([t]))[0], range(0, 400, 29))
    assert worst < 1e-9
    assert run.unit("slew.motor_torque") == "N m"
    assert run.unit("extend.friction_force") == run.unit("extend.cylinder_force") == "N"


def test_pins_of_a_shipped_machine_too():
    loader = load_machine("wheel_loader")
    run = simulate(loader, "exact", random_operator(1, 2.0, functions=loader.names), forces=True)
    assert not [event for event in run.info["events"] if "stop" in event[2]]
    assert np.ptp(run["tilt.angle"]) > 0.02
    assert held_to_mujoco(loader, run, lambda t: np.zeros(3), range(0, 400, 29)) < 1e-9


@pytest.mark.slow_to_compile
def test_the_first_pin_carries_all_weights_and_friction_what_is_missing(crane):
    dry = Friction(2e4, 3e4, 100.0, 0.02, 0.05)
    stiff = with_effects(crane, sticks=True)
    stiff = stiff._replace(functions=tuple(f._replace(friction=dry) for f in stiff.functions))
    run = simulate(stiff, "exact", Scenario("still", 0.5, {}), forces=True)
    assert not run["lift.rate"].any()
    weight = crane.gravity * sum(link.mass for link in crane.links)
    assert np.allclose(run["slew.pin_force_z"], weight, rtol=1e-12)
    assert np.allclose(run["slew.pin_force_x"], 0.0, atol=1e-6)
    frames = link_frames(crane, np.array([[f.initial.angle for f in crane.functions]]))
    arms = {name: placed(frames, name, crane.link(name).cg)[0] for name in ("boom", "arm")}
    joint = frames["boom"][1][0]
    heading = np.array(
        [np.cos(crane.function("slew").initial.angle), np.sin(crane.function("slew").initial.angle), 0.0]
    )
    needed = sum(crane.gravity * crane.link(name).mass * ((arm - joint) @ heading) for name, arm in arms.items())
    f = crane.function("lift")
    head, rod = np.pi / 4 * f.drive.bore**2, np.pi / 4 * (f.drive.bore**2 - f.drive.rod**2)
    assert np.allclose(run["lift.cylinder_force"], run["lift.p_a"] * head - run["lift.p_b"] * rod, rtol=1e-12)
    oil = run["lift.cylinder_force"] * lever(f, crane.link("boom"), f.initial.angle)
    assert np.allclose(oil - run["lift.friction_torque"], needed, rtol=1e-9)


def test_pieces_and_locks_change_nothing_else(crane):
    scenario = random_operator(3, 1.0, links=("lift", "extend"), functions=crane.names)
    options = {"dt": 5e-3, "t_end": None, "every": 5, "method": "semi-implicit"}
    run = simulate(crane, "exact", scenario)
    both = simulate_layout(crane, "exact", scenario, piece=33, energy=True, forces=True, **options)
    assert all(np.array_equal(both[name], run[name][::5]) for name in run.names)
    assert "energy.kinetic" in both.names
    assert "lift.pin_force_z" in both.names
    assert not [name for name in both.names if name.startswith("slew.pin")]


@pytest.mark.slow
def test_a_method_that_chooses_its_own_steps_gives_the_same_forces(crane):
    scenario = replace(random_operator(4, 0.8, functions=crane.names), loads=Loads({"z": Constant(-500.0)}))
    fine = simulate(crane, "exact", scenario, dt=2.5e-4, every=40, forces=True)
    own = simulate(crane, "exact", scenario, dt=1e-2, method="rosenbrock", rtol=1e-6, forces=True)
    for name in ("lift.cylinder_force", "lift.pin_force_z", "slew.pin_moment_y", "extend.friction_force"):
        assert np.allclose(own[name], fine[name], atol=0.03 * np.ptp(fine[name])), name
