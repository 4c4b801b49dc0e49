"""The generated equations of motion next to those written by hand for three joints: angles, mass matrix, torques and solution.

``python benchmarks/tree_motion.py`` prints and asserts nothing. Each call goes through the same random states and sums all that
it finds, so that nothing is left out. Times are processor times of the calling thread.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from helpers.trees import GRAVITY, TREES, mechanics, random_states
from polydraulic import load_machine
from polydraulic._kernel import driver, kernel
from polydraulic.elementary import sincos
from polydraulic.machine.linkage import Held, motion, prepare_linkage, solve_motion
from polydraulic.machine.state import Links
from polydraulic.machine.tree.motion_text import moving
from polydraulic.thesis.timing import paired_times
from show import show

STATES, REPEATS = 1024, 200  # a power of two; a call is long, since it takes time to look at its arguments
TOTAL = '''

@kernel
def joints(rows, i):
    return Joints(ROW)


@driver
def total(q, v, torque, held, constants):
    """Sum of all accelerations."""
    found = 0.0
    for k in range(REPEATS * q.shape[0]):
        i = k % q.shape[0]
        m = motion(turns(joints(q, i)), joints(v, i), constants)
        push = joints(torque, i)
        a = solve_motion(m.mass, held, Joints(RIGHT))
        found += SUM
    return found
'''


def total_text(names):
    """A loop for joints of these names."""
    texts = {
        "ROW": [f"rows[i, {k}]" for k in range(len(names))],
        "RIGHT": [f"push.{name} - m.bias.{name} - m.gravity.{name}" for name in names],
        "REPEATS": [str(REPEATS)],
    }
    text = TOTAL.replace("SUM", " + ".join(f"a.{name}" for name in names))
    for word, parts in texts.items():
        text = text.replace(word, ", ".join(parts))
    return text


@kernel
def links_of(rows, i):
    return Links(rows[i, 0], rows[i, 1], rows[i, 2])


@driver
def total_by_hand(q, v, torque, held, linkage):
    found = 0.0
    for k in range(REPEATS * q.shape[0]):
        i = k % q.shape[0]
        angle, rate, push = links_of(q, i), links_of(v, i), links_of(torque, i)
        m = motion(sincos(angle.boom), sincos(angle.stick), rate, linkage)
        right = Links(
            push.swing - m.bias.swing - m.gravity.swing,
            push.boom - m.bias.boom - m.gravity.boom,
            push.stick - m.bias.stick - m.gravity.stick,
        )
        a = solve_motion(m.mass, held, right)
        found += a.swing + a.boom + a.stick
    return found


def main():
    states = random_states(TREES["three links"], STATES)
    linkage, held = prepare_linkage(load_machine("cat215b")), Held(False, False, False)
    calls = {"three links by hand": lambda: total_by_hand(*states, held, linkage)}
    with tempfile.TemporaryDirectory() as folder:
        for name, links in TREES.items():
            names = moving(links)
            module = mechanics(Path(folder), links, more=total_text(names))
            arguments = (*random_states(links, STATES), module.Held(*[False] * len(names)))
            arguments = (*arguments, module.prepare_motion(links, GRAVITY))
            calls[f"generated: {name} ({len(names)} joints)"] = lambda m=module, a=arguments: m.total(*a)
        show("Angles, equations of motion and solution of a state", paired_times(calls), "ns", per=STATES * REPEATS)


if __name__ == "__main__":
    main()
