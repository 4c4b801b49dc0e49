"""Trees of links with the numbers of real machines and of none, their mechanics as modules, and the same as MuJoCo models."""

import hashlib
import importlib.util
import sys

import numpy as np
import pytest

from polydraulic.machine.tree.links import TENSOR, VECTOR, Link
from polydraulic.machine.tree.motion_text import MOTION_IMPORTS, motion_text, moving

GRAVITY = 9.81
DRIVERS = '''

@driver
def accelerate(q, v, torque, held, constants, found):
    """Accelerations of many states, one a row."""
    for i in range(q.shape[0]):
        m = motion(turns(joints(q[i])), joints(v[i]), constants)
        right = less(less(joints(torque[i]), m.bias), m.gravity)
        put(found[i], solve_motion(m.mass, held, right))
'''


def with_joints(links):
    """The head of a file that holds the mechanics, and what takes joints apart."""
    names = moving(links)
    n = range(len(names))
    return "\n".join(
        [
            *MOTION_IMPORTS,
            "from polydraulic._kernel import driver",
            "\n\nclass Joints(NamedTuple):",
            *(f"    {name}: float" for name in names),
            "\n\nclass Held(NamedTuple):",
            *(f"    {name}: bool" for name in names),
            "\n\n@kernel\ndef joints(row):",
            f"    return Joints({', '.join(f'row[{i}]' for i in n)})",
            "\n\n@kernel\ndef less(a, b):",
            f"    return Joints({', '.join(f'a.{name} - b.{name}' for name in names)})",
            "\n\n@kernel\ndef put(row, x):",
            *(f"    row[{i}] = x.{name}" for i, name in enumerate(names)),
            "\n\n",
        ]
    )


def mechanics(folder, links, points=(), more=DRIVERS):
    """The mechanics of `links` as a module, from a real file in `folder`."""
    text = with_joints(links) + motion_text(links, points=points) + more
    name = f"mechanics_{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    path = folder / f"{name}.py"
    path.write_text(text)
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # annotations are looked up there
    spec.loader.exec_module(module)
    return module


def body(rng, mass, *, cg=VECTOR, inertia=TENSOR):
    """Numbers of a random rigid body, of its declared components."""
    points = rng.normal(0.0, 1.0, (8, 3)) * rng.uniform(0.2, 0.8, 3)
    points -= points.mean(0)
    second = mass / 8 * points.T @ points
    tensor = np.trace(second) * np.eye(3) - second
    places = {a + b: (VECTOR.index(a), VECTOR.index(b)) for a, b in TENSOR}
    return {
        "mass": mass,
        "cg": {c: float(rng.uniform(-1.0, 1.0)) for c in cg},
        "inertia": {c: float(tensor[places[c]]) for c in inertia},
    }


def excavator(links=3, **more):
    """Swing, boom and stick, and a bucket as the fourth."""
    plane, diagonal = ("x", "z"), TENSOR[:3]
    rng = np.random.default_rng(1)
    found = [
        Link("swing", None, "revolute", "z", inertia={"zz": 25000.0}),
        Link("boom", "swing", "revolute", "-y", {"x": 0.81, "y": 0.12}, **body(rng, 1400.0, cg=plane, inertia=diagonal)),
        Link("stick", "boom", "revolute", "-y", {"x": 5.19}, **body(rng, 700.0, cg=plane, inertia=diagonal)),
        Link("bucket", "stick", "revolute", "-y", {"x": 2.3, "z": 0.1}, **body(rng, 500.0, cg=plane, inertia=diagonal)),
    ]
    return found[:links]


def six():
    """Six joints about all axes, with every component declared."""
    rng, axes = np.random.default_rng(2), ("z", "-y", "y", "x", "-y", "-z")
    names = ("base", "shoulder", "elbow", "roll", "wrist", "tool")
    return [
        Link(
            name,
            names[i - 1] if i else None,
            "revolute",
            axis,
            {c: float(rng.uniform(-1.0, 1.0)) for c in VECTOR},
            **body(rng, 600.0 / (i + 1)),
        )
        for i, (name, axis) in enumerate(zip(names, axes, strict=True))
    ]


def crane():
    """A boom in two parts of which one slides, a jib, and a hook block that is fixed to it."""
    rng = np.random.default_rng(3)
    return [
        Link("column", None, "revolute", "z", {"z": 1.2}, **body(rng, 900.0, cg=("x",), inertia=TENSOR[:3])),
        Link("boom", "column", "revolute", "-y", {"x": 0.3, "z": 1.1}, **body(rng, 700.0)),
        Link("extension", "boom", "prismatic", "x", {"x": 2.0, "z": 0.05}, **body(rng, 300.0, cg=("x", "z"))),
        Link("jib", "extension", "revolute", "-y", {"x": 1.5}, **body(rng, 200.0, cg=("x", "z"))),
        Link("block", "jib", "fixed", None, {"x": 1.1, "z": -0.3}, **body(rng, 150.0, cg=("z",))),
    ]


def branching():
    """A carriage on the ground that carries two arms, one with a joint without mass, and a lift."""
    rng = np.random.default_rng(4)
    return [
        Link("carriage", None, "prismatic", "-x", {"z": 0.5}, **body(rng, 2000.0)),
        Link("cab", "carriage", "revolute", "z", {"x": 0.2}, **body(rng, 1000.0)),
        Link("lift", "cab", "prismatic", "z", {"x": 1.0, "y": -0.4}, **body(rng, 300.0)),
        Link("fork", "lift", "revolute", "y", {"x": 0.5}, **body(rng, 200.0)),
        Link("gimbal", "cab", "revolute", "y", {"x": 0.4, "y": 0.6, "z": 0.3}),
        Link("arm", "gimbal", "revolute", "-x", {"x": 0.1}, **body(rng, 250.0)),
        Link("slide", "arm", "prismatic", "-z", {"y": 0.3}, **body(rng, 90.0)),
        Link("grab", "arm", "revolute", "-x", {"y": 0.7}, **body(rng, 60.0)),
    ]


TREES = {
    "three links": excavator(3),
    "four links": excavator(4),
    "six links": six(),
    "telescopic boom": crane(),
    "branches": branching(),
}


def random_states(links, n, seed=0):
    """Positions, rates and torques, one state a row: rad and m, rad/s and m/s, N m and N."""
    rng, k = np.random.default_rng(seed), len(moving(links))
    return rng.uniform(-3.0, 3.0, (n, k)), rng.uniform(-1.5, 1.5, (n, k)), rng.uniform(-2e4, 2e4, (n, k))


def mujoco_model(links):
    """The same tree; joints of links without mass belong to the body of the link behind them."""
    mujoco = pytest.importorskip("mujoco")

    def numbers(given):
        return " ".join(repr(float(x)) for x in given)

    def vector(given):
        return np.array([given.get(c, 0.0) for c in VECTOR])

    def nested(link, joints, at):
        joints = [(axis, kind, place - vector(link.at)) for axis, kind, place in joints]
        if link.joint != "fixed":
            direction = np.array([float(c == link.axis[-1]) for c in VECTOR]) * (-1.0 if link.axis[0] == "-" else 1.0)
            joints.append((direction, "hinge" if link.joint == "revolute" else "slide", np.zeros(3)))
        at, behind = at + vector(link.at), [other for other in links if other.parent == link.name]
        if link.mass is None and not link.inertia:
            (child,) = behind
            return nested(child, joints, at)
        if link.mass is None:  # turns about its own axis alone
            inertial = f'pos="0 0 0" mass="1" diaginertia="{numbers([link.inertia["zz"]] * 3)}"'
        else:
            tensor = [link.inertia.get(c, 0.0) for c in TENSOR]
            inertial = f'pos="{numbers(vector(link.cg))}" mass="{link.mass!r}" fullinertia="{numbers(tensor)}"'
        return "".join(
            [
                f'<body name="{link.name}" pos="{numbers(at)}">',
                *(f'<joint type="{k}" axis="{numbers(a)}" pos="{numbers(p)}"/>' for a, k, p in joints),
                f"<inertial {inertial}/>",
                *(nested(child, [], np.zeros(3)) for child in behind),
                "</body>",
            ]
        )

    bodies = "".join(nested(link, [], np.zeros(3)) for link in links if link.parent is None)
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler balanceinertia="false"/><option gravity="0 0 {-GRAVITY!r}"/>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )
