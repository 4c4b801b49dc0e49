"""The generated equations of motion of trees with three joints to six: angles, mass matrix, torques and solution.

``python benchmarks/tree_motion.py`` prints and asserts nothing. Each call goes through the same random states and sums all
accelerations that it finds, so that nothing is left out. Times are processor times of the calling thread.
"""

import importlib.util
import sys
import tempfile
from pathlib import Path

import numpy as np

from polydraulic.machine.tree.links import Link
from polydraulic.machine.tree.motion_text import MOTION_IMPORTS, motion_text, moving
from polydraulic.thesis.timing import paired_times
from show import show

STATES, REPEATS = 1024, 200  # a call is long, since it takes a while to look at its arguments
LOOP = """

@kernel
def joints(rows, i):
    return Joints({row})


@driver
def total(q, v, torque, held, constants, n):
    found = 0.0
    for k in range(n * q.shape[0]):
        i = k % q.shape[0]
        m = motion(turns(joints(q, i)), joints(v, i), constants)
        push = joints(torque, i)
        a = solve_motion(m.mass, held, Joints({right}))
        found += {sum}
    return found
"""


def arm(name, parent, joint, axis, **place):
    """A link that is long in x, with a centre of gravity off its middle."""
    return Link(name, parent, joint, axis, place, 500.0, {"x": 1.0, "z": 0.1}, {"xx": 20.0, "yy": 200.0, "zz": 200.0})


SWING = Link("swing", None, "revolute", "z", inertia={"zz": 25000.0})
THREE = [
    SWING,
    arm("boom", "swing", "revolute", "-y", x=0.81, y=0.12),
    arm("stick", "boom", "revolute", "-y", x=5.19),
]
TREES = {
    "three joints": THREE,
    "four, one a bucket": [*THREE, arm("bucket", "stick", "revolute", "-y", x=1.8)],
    "four, one a telescopic boom": [
        *THREE[:2],
        arm("extension", "boom", "prismatic", "x", x=3.0),
        arm("jib", "extension", "revolute", "-y", x=2.0),
    ],
    "six, a bucket that tilts and turns": [
        *THREE,
        arm("bucket", "stick", "revolute", "-y", x=1.8),
        arm("tilt", "bucket", "revolute", "x", x=0.3),
        arm("turn", "tilt", "revolute", "z", z=-0.3),
    ],
}


def random_states(n_joints):
    rng = np.random.default_rng(0)
    return [rng.uniform(-limit, limit, (STATES, n_joints)) for limit in (3.0, 1.5, 2e4)]


def generated(links, folder):
    """The sum over all states, by a module in a file of its own."""
    names = moving(links)
    loop = LOOP.format(
        row=", ".join(f"rows[i, {k}]" for k in range(len(names))),
        right=", ".join(f"push.{name} - m.bias.{name} - m.gravity.{name}" for name in names),
        sum=" + ".join(f"a.{name}" for name in names),
    )
    tuples = [
        f"class {tuple_name}(NamedTuple):\n" + "".join(f"    {name}: {kind}\n" for name in names)
        for tuple_name, kind in (("Joints", "float"), ("Held", "bool"))
    ]
    imports = [*MOTION_IMPORTS, "from polydraulic._kernel import driver"]
    path = folder / f"{'_'.join(names)}.py"
    path.write_text("\n".join([*imports, *tuples, motion_text(links), loop]))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    held, constants = module.Held(*[False] * len(names)), module.prepare_motion(links, 9.81)
    states = random_states(len(names))
    return lambda: module.total(*states, held, constants, REPEATS)


def main():
    with tempfile.TemporaryDirectory() as folder:
        calls = {name: generated(links, Path(folder)) for name, links in TREES.items()}
        show(
            "Angles, equations of motion and their solution in one state",
            paired_times(calls),
            "ns",
            per=STATES * REPEATS,
        )


if __name__ == "__main__":
    main()
