"""What is no tree, and no rigid body, is refused by name and value."""

import numpy as np
import pytest

from helpers.trees import TREES, excavator, random_states
from polydraulic.errors import InputError
from polydraulic.machine.tree.link_checks import _mass_matrix, check_tree
from polydraulic.machine.tree.links import Link

BALL = {"xx": 1.0, "yy": 1.0, "zz": 1.0}


def arm(**other):
    return Link("arm", None, "revolute", "y", {"x": 1.0}, 10.0, {"x": 0.5}, BALL)._replace(**other)


def refused(*links):
    with pytest.raises(InputError) as error:
        check_tree(links)
    return str(error.value)


@pytest.mark.parametrize("links", TREES.values(), ids=TREES)
def test_machines_pass(links):
    check_tree(links)


@pytest.mark.parametrize("name", ["", "2nd", "boom arm", "lambda", "_arm", "count", "bøm", "a" * 41])
def test_a_name_becomes_code(name):
    assert f"link {name!r}: a name is 1 to 40 ASCII letters" in refused(arm(name=name))


def test_what_cannot_be_hashed_is_named_like_any_other_value():
    assert refused(arm(axis=["z"])) == "link arm: axis ['z']; must be one of x, y, z, -x, -y, -z"
    assert refused(arm(parent=["boom"])).startswith("link arm hangs on ['boom'], which is no link")


def test_links_form_a_tree_parents_first():
    hand = arm(name="hand", parent="arm")
    assert refused(hand, arm()) == (
        "link hand hangs on arm, which comes later: links form a tree without cycles, and stand in kinematic order, parents first"
    )
    assert "which comes later" in refused(arm(parent="hand"), hand)  # a cycle
    assert refused(arm(parent="arm")).startswith("link arm hangs on itself")
    assert (
        refused(arm(), hand._replace(parent="boom"))
        == "link hand hangs on 'boom', which is no link; links are arm, hand"
    )
    assert refused(arm(), arm()) == "link arm is there twice; give each link a name of its own"


def test_as_many_links_as_a_machine_may_have():
    assert refused() == "0 links; a machine has 1 to 12"
    chain = [arm(name=f"l{i}", parent=f"l{i - 1}" if i else None) for i in range(13)]
    check_tree(chain[:12])
    assert refused(*chain) == "13 links; a machine has 1 to 12"


def test_joints_and_axes_are_those_there_are():
    assert refused(arm(joint="ball")) == "link arm: joint 'ball'; must be one of revolute, prismatic, fixed"
    assert refused(arm(axis="+y")) == "link arm: axis '+y'; must be one of x, y, z, -x, -y, -z"
    assert "a fixed joint has no axis" in refused(arm(joint="fixed"))
    assert refused(arm(joint="fixed", axis=None)).startswith("no link can move")


def test_components_and_numbers_are_named():
    assert refused(arm(cg={"w": 1.0})) == "link arm: cg has no component 'w'; it has x, y, z"
    assert refused(arm(at={"x": float("nan")})) == "link arm: at x is nan, which is no number"
    assert refused(arm(mass=0.0)).startswith("link arm: mass 0.0 kg; must be above 0")
    assert refused(arm(mass=-3.0)).startswith("link arm: mass -3.0 kg")
    assert refused(arm(mass=float("inf"))).startswith("link arm: mass inf kg")
    assert "has a centre of gravity but no mass" in refused(arm(mass=None))


def test_inertia_is_that_of_a_rigid_body():
    turret = Link("turret", None, "revolute", "z", inertia={"zz": 5.0})
    hung = arm(parent="turret")
    check_tree([turret, hung])
    assert refused(turret, hung._replace(inertia=BALL | {"xx": -1.0})) == (
        "link arm: inertia xx is -1.0 kg m2; must not be below 0"
    )
    assert "principal moments of inertia are -1, 1 and 3 kg m2; none may be below 0" in refused(
        turret, hung._replace(inertia=BALL | {"xy": 2.0})
    )
    assert "1, 1 and 2.1 kg m2; in a rigid body none is larger than the other two together" in refused(
        turret, hung._replace(inertia=BALL | {"zz": 2.1})
    )
    check_tree([turret, hung._replace(inertia=BALL | {"zz": 2.0})])  # a disc
    check_tree([turret, hung._replace(inertia={"yy": 1.0, "zz": 1.0})])  # a rod


def test_one_direction_of_turning_needs_one_inertia():
    check_tree([arm(inertia={"yy": 2.0}), arm(name="hand", parent="arm", inertia={"yy": 2.0})])
    turret = Link("turret", None, "revolute", "z", inertia={"zz": 5.0})
    assert "declare all of them" in refused(turret, arm(parent="turret", inertia={"yy": 2.0}))


def test_something_must_resist_every_joint():
    slide = Link("slide", None, "prismatic", "x", inertia=BALL)
    assert refused(slide) == (
        "link slide: nothing resists the motion of its joint; give slide, or what hangs on it, mass"
    )
    point = arm(mass=5.0, cg={}, inertia={})
    assert "mass off its axis, or inertia yy" in refused(point)
    roll = Link("roll", "arm", "revolute", "x", {"x": 1.0}, 5.0, {"x": 0.3})
    assert refused(arm(), roll).startswith("link roll: nothing resists")
    rod = roll._replace(inertia={"yy": 1.0, "zz": 1.0})
    assert refused(arm(), rod).startswith("link roll: nothing resists")
    check_tree([arm(), roll._replace(cg={"y": 0.3})])


def test_a_link_without_mass_carries_one_with_mass():
    check_tree([Link("gimbal", None, "revolute", "z"), arm(parent="gimbal")])
    # two joints about one axis at one place: only their sum is resisted
    assert "nothing resists" in refused(Link("gimbal", None, "revolute", "y"), arm(parent="gimbal", at={}))


def test_the_mass_matrix_of_the_check_is_that_of_the_physics():
    """The kinetic energy of points that make up the links, by differences of their places."""
    links = excavator(3)
    q, v, _ = (values[0] for values in random_states(links, 1))
    mass = _mass_matrix(links, q)
    assert mass == pytest.approx(mass.T)
    (_, boom, stick), d, foot = q, 0.12, 0.81

    def centres(swing, boom, stick):
        radial, aside = np.array([np.cos(swing), np.sin(swing), 0.0]), np.array([-np.sin(swing), np.cos(swing), 0.0])

        def at(angle, x, z):
            return (x * np.cos(angle) - z * np.sin(angle)) * radial + np.array(
                [0, 0, x * np.sin(angle) + z * np.cos(angle)]
            )

        base, tip = foot * radial + d * aside, at(boom, 5.19, 0.0)
        a, b = links[1].cg, links[2].cg
        return base + at(boom, a["x"], a["z"]), base + tip + at(boom + stick, b["x"], b["z"])

    h = 1e-6
    high, low = (centres(*(q + sign * h * v)) for sign in (1.0, -1.0))
    energy = sum(
        0.5 * link.mass * np.sum(((up - down) / (2 * h)) ** 2)
        for link, up, down in zip(links[1:], high, low, strict=True)
    )
    energy += 0.5 * links[0].inertia["zz"] * v[0] ** 2
    for link, angle, rate in ((links[1], boom, v[1]), (links[2], boom + stick, v[1] + v[2])):
        spin = np.array([v[0] * np.sin(angle), -rate, v[0] * np.cos(angle)])  # along the link's own axes
        energy += 0.5 * sum(link.inertia[c + c] * s**2 for c, s in zip("xyz", spin, strict=True))
    assert 0.5 * v @ mass @ v == pytest.approx(energy, rel=1e-8)
