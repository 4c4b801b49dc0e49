import numpy as np
import pytest

from helpers.made_runs import point_at, small_crane, spread
from polydraulic import load_machine
from polydraulic.parameters.layout.geometry import knee_at
from polydraulic.plotting.drawing import PLANE, Spot, motion_of, places, seen, silhouette, view_limits
from polydraulic.plotting.layout_shapes import layout_drawing

MACHINES = {
    "bucket": lambda: load_machine("cat215b_bucket"),
    "crane": small_crane,
    "crane slewing the other way": lambda: small_crane("-z"),
}


@pytest.fixture(params=list(MACHINES))
def machine(request):
    return MACHINES[request.param]()


def test_the_drawn_tip_is_the_machines(machine):
    drawing, positions = layout_drawing(machine), spread(machine, 40)
    tips = np.array([point_at(machine, row, *machine.tip) for row in positions])
    drawn = places(motion_of(drawing, positions), [drawing.tip])[:, 0]
    assert drawn == pytest.approx(tips, abs=1e-12)


def test_the_side_view_turns_with_the_arm(machine):
    """What lies beside the upright axis keeps its distance from the plane through it, whichever way the arm points."""
    drawing, positions = layout_drawing(machine), spread(machine, 40)
    first = machine.link(machine.functions[0].moves)
    motion = motion_of(drawing, positions)
    tips = places(motion, [drawing.tip])
    side = seen(motion, "side", tips)[:, 0]
    along = np.hypot(tips[:, 0, 0] - first.at.get("x", 0.0), tips[:, 0, 1] - first.at.get("y", 0.0))
    beside = machine.links[1].at.get("y", 0.0)
    assert np.hypot(side[:, 0], beside) == pytest.approx(along)
    assert side[:, 1] == pytest.approx(tips[:, 0, 2])
    assert np.array_equal(seen(motion, "top", tips), tips[..., :2])
    still = seen(motion, "side", places(motion, [Spot(PLANE, (1.0, 0.0, 2.0))]))
    assert still == pytest.approx(np.broadcast_to([1.0, 2.0], still.shape))


def test_without_an_upright_axis_the_side_is_that_of_x_and_z():
    crane = small_crane()
    lift = [f for f in crane.functions if f.name != "slew"]
    jib, extension = crane.link("jib")._replace(parent="ground"), crane.link("extension")
    fixed = crane._replace(links=(jib, extension), functions=tuple(lift))
    drawing = layout_drawing(fixed)
    motion = motion_of(drawing, np.array([[0.4, 0.5]]))
    assert not drawing.slews
    x, _, z = point_at(fixed, [0.4, 0.5], *fixed.tip)
    assert seen(motion, "side", places(motion, [drawing.tip]))[0, 0] == pytest.approx([x, z])


def test_rocker_and_coupler_keep_their_lengths_and_meet():
    """The four-bar linkage is drawn closed at every position: knee and pin as far apart as where the file gives the knee."""
    machine = load_machine("cat215b_bucket")
    drawing, positions = layout_drawing(machine), spread(machine, 80)
    knee, hinge, pin = np.moveaxis(
        places(motion_of(drawing, positions), [drawing.pins[f"bucket {name}"] for name in ("knee", "hinge", "pin")]), 1, 0
    )  # fmt: skip
    # by the numbers of the file, with the joint of the bucket 1.8 m along the stick
    assert np.linalg.norm(knee - hinge, axis=1) == pytest.approx(np.hypot(1.35 - 1.4, 0.53 - 0.05))
    assert np.linalg.norm(knee - pin, axis=1) == pytest.approx(np.hypot(1.35 - 1.8 + 0.07, 0.53 - 0.39))


def test_a_rocker_stays_where_its_linkage_ends():
    machine = load_machine("cat215b_bucket")
    drawing = layout_drawing(machine)
    motion = motion_of(drawing, np.array([[0.0, 0.0, -1.0, q] for q in np.linspace(0.0, 6.0, 50)]))
    rocker = motion.positions[:, 4]
    reached = [knee_at(drawing.followers[0].rocker, q) is not None for q in motion.positions[:, 3]]
    assert reached[0]
    assert not all(reached)
    ended = reached.index(False)
    assert rocker[ended] == rocker[ended - 1] != rocker[ended - 2]
    assert np.all(np.isfinite(rocker))


def test_a_silhouette_holds_its_balls():
    points, radii = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.1]]), (0.3, 0.1, 0.05)
    hull = silhouette(points, radii)
    assert hull[:, 0].min() == pytest.approx(-0.3)
    assert hull[:, 0].max() == pytest.approx(2.1)
    assert np.abs(hull[:, 1]).max() == pytest.approx(0.3)
    (x, y), (x1, y1) = np.diff([*hull, hull[0]], axis=0).T, np.diff([*hull[1:], *hull[:2]], axis=0).T
    assert np.all(x * y1 - y * x1 > 0.0)  # turns to the left all round
    assert silhouette(points, ()) is points


def test_a_view_shows_all_of_the_machine(machine):
    drawing, motion = layout_drawing(machine), motion_of(layout_drawing(machine), spread(machine, 40))
    for view in ("side", "top"):
        low, high = view_limits(drawing, [motion], view)
        for body in drawing.bodies:
            if view in body.views:
                points = seen(motion, view, places(motion, body.spots))
                assert np.all((points >= low) & (points <= high))
