"""Trees of links with the numbers of real machines and of none, their mechanics as modules, and the same as MuJoCo models."""

import hashlib
import importlib.util
import re
import sys

import numpy as np
import pytest

from polydraulic.machine.tree.links import TENSOR, VECTOR, Link
from polydraulic.machine.tree.motion_text import MOTION_IMPORTS, motion_text, moving

GRAVITY = 9.81
_PLAIN = """
def kernel(function):
    return function


driver, sincos = kernel, getattr(sincos, "py_func", sincos)
"""


def head(links):
    """What a file has before the mechanics: imports, `Joints` and `Held`."""
    lines = [*MOTION_IMPORTS, "from polydraulic._kernel import driver", "\n\nclass Joints(NamedTuple):"]
    lines += [f"    {name}: float" for name in moving(links)]
    lines += ["\n\nclass Held(NamedTuple):", *(f"    {name}: bool" for name in moving(links)), "\n\n"]
    return "\n".join(lines)


def loaded(folder, text):
    """A module of this text, from a real file in `folder`."""
    name = f"mechanics_{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    path = folder / f"{name}.py"
    path.write_text(text)
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # annotations are looked up there
    spec.loader.exec_module(module)
    return module


def mechanics(folder, links, points=(), more="", *, plain=False):
    """The mechanics of `links` and `more` text as a module; `plain`: not compiled."""
    return loaded(folder, head(links) + (_PLAIN if plain else "") + "\n\n" + motion_text(links, points=points) + more)


def mass_entries(links):
    """Names of the fields of a mass matrix, with row and column."""
    fields = re.findall(r"^    (m\w+): float  # (\w+)(?:, (\w+))?$", motion_text(links), re.MULTILINE)
    names = moving(links)
    return {field: (names.index(a), names.index(b or a)) for field, a, b in fields}


def everything(links):
    """All that the mechanics give: what stands in each column of a row, and the text of functions that fill it.

    `evaluate` takes plain arrays, so that one text runs compiled, in Python and as C; `evaluate_all` many states, one a row.
    """
    names, last = moving(links), links[-1].name
    columns = [f"m.mass.{field}" for field in mass_entries(links)]
    for what in ("m.bias", "m.gravity", "a", "p", "push"):
        columns += [f"{what}.{name}" for name in names]
    columns += ["place.x", "place.y", "place.z", "height", "motion_energy"]

    def row(array):
        return ", ".join(f"{array}[{i}]" for i in range(len(names)))

    n_constants = (
        motion_text(links, points=[last]).partition("class Constants")[2].partition("def ")[0].count(": float")
    )
    right = ", ".join(f"torque[{i}] - m.bias.{name} - m.gravity.{name}" for i, name in enumerate(names))
    held = ", ".join(f"held[{i}] > 0.5" for i in range(len(names)))
    point = ", ".join(f"point[{i}]" for i in range(6))
    text = [
        "\n\n@kernel",
        "def evaluate(q, v, torque, held, point, c, found):",
        f"    constants = Constants({', '.join(f'c[{i}]' for i in range(n_constants))})",
        f"    turn = turns(Joints({row('q')}))",
        f"    rate = Joints({row('v')})",
        "    m = motion(turn, rate, constants)",
        f"    right = Joints({right})",
        f"    holding = Held({held})",
        "    a = solve_motion(m.mass, holding, right)",
        "    p = times(m.mass, rate)",
        f"    place = place_{last}(turn, {point[:28]}, constants)",
        f"    push = push_{last}(turn, {point}, constants)",
        "    height = potential(turn, constants)",
        "    motion_energy = kinetic(m.mass, rate)",
        *(f"    found[{i}] = {column}" for i, column in enumerate(columns)),
        "    return 0.0",
        "\n\n@driver",
        "def evaluate_all(q, v, torque, held, point, c, found):",
        "    for i in range(q.shape[0]):",
        "        evaluate(q[i], v[i], torque[i], held[i], point[i], c, found[i])",
        "",
    ]
    return columns, "\n".join(text)


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
        Link(
            "boom", "swing", "revolute", "-y", {"x": 0.81, "y": 0.12}, **body(rng, 1400.0, cg=plane, inertia=diagonal)
        ),
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


def random_tree(seed):
    """Any joints about any axes, in any order, with whatever components are declared."""
    rng = np.random.default_rng(seed)

    def some(names):
        return tuple(name for name in names if rng.random() < 0.6)

    links = []
    for i in range(int(rng.integers(1, 9))):
        joint = str(rng.choice(["revolute", "revolute", "revolute", "prismatic", "fixed"])) if i else "revolute"
        axis = None if joint == "fixed" else str(rng.choice(["x", "y", "z", "-x", "-y", "-z"]))
        parent = None if i == 0 or rng.random() < 0.1 else f"l{rng.integers(max(0, i - 2), i)}"
        place = {c: float(rng.uniform(-1.0, 1.0)) for c in some(VECTOR)}
        numbers = body(rng, float(rng.uniform(1.0, 500.0)), cg=some(VECTOR), inertia=TENSOR if i % 2 else TENSOR[:3])
        links.append(Link(f"l{i}", parent, joint, axis, place, **numbers))
    return links


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
        joints = [(kind, axis, place - vector(link.at)) for kind, axis, place in joints]
        if link.joint != "fixed":
            direction = np.array([float(c == link.axis[-1]) for c in VECTOR]) * (-1.0 if link.axis[0] == "-" else 1.0)
            kind = "hinge" if link.joint == "revolute" else "slide"
            joints.append((f'name="{link.name}" type="{kind}"', direction, np.zeros(3)))
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
                *(f'<joint {kind} axis="{numbers(a)}" pos="{numbers(p)}"/>' for kind, a, p in joints),
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
