import numpy as np
import pytest

from helpers.made_runs import point_at, small_crane, spread
from polydraulic import load_machine
from polydraulic.parameters.load import machine_names
from polydraulic.plotting.carrier import CAB, GLASS
from polydraulic.plotting.drawing import OF_RUN, PLANE, motion_of, places, seen
from polydraulic.plotting.layout_shapes import layout_drawing


@pytest.mark.parametrize(
    ("build", "function"), [(lambda: load_machine("cat215b_bucket"), "boom"), (small_crane, "lift")]
)
def test_pins_of_a_cylinder_are_as_far_apart_as_its_triangle_says(build, function):
    """Law of cosines from distances and directions of both pins, seen from the joint at zero."""
    machine = build()
    drawing, positions = layout_drawing(machine), spread(machine, 60)
    f = machine.function(function)
    link, place = machine.link(f.moves), machine.names.index(function)
    base = np.array([f.pins.base.get(c, 0.0) - link.at.get(c, 0.0) for c in "xz"])
    rod = np.array([f.pins.rod.get(c, 0.0) for c in "xz"])
    between = np.arctan2(*rod[::-1]) - np.arctan2(*base[::-1]) + positions[:, place]
    r_base, r_rod = np.linalg.norm(base), np.linalg.norm(rod)
    length = np.sqrt(r_base**2 + r_rod**2 - 2.0 * r_base * r_rod * np.cos(between))
    ram = next(ram for ram in drawing.rams if ram.base == drawing.pins[f"{function} base"])
    motion = motion_of(drawing, positions)
    ends = seen(motion, "side", places(motion, [ram.base, ram.rod]))
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx(length)
    assert 0.5 * length.min() < ram.barrel < length.min()


def test_the_bucket_cylinder_ends_at_the_knee():
    drawing = layout_drawing(load_machine("cat215b_bucket"))
    assert drawing.rams[-1].base == drawing.pins["bucket base"]
    assert drawing.rams[-1].rod == drawing.pins["bucket knee"]
    positions = np.array([[0.0, 0.3, -1.0, 0.0]])
    machine = load_machine("cat215b_bucket")
    knee = point_at(machine, positions[0], "stick", {"x": 1.35, "z": 0.53})  # where the file says it is at zero
    assert places(motion_of(drawing, positions), [drawing.rams[-1].rod])[0, 0] == pytest.approx(knee)


def test_every_link_is_drawn():
    for machine in (load_machine("cat215b_bucket"), small_crane()):
        drawn = {body.spots[0].link for body in layout_drawing(machine).bodies}
        assert {link.name for link in machine.links} <= drawn


def test_an_extension_is_drawn_from_its_guide_to_its_tip():
    drawing = layout_drawing(small_crane())
    body = next(body for body in drawing.bodies if body.spots[0].link == "extension")
    ends = places(motion_of(drawing, np.array([[0.0, 0.0, 0.9]])), body.spots)[0, :, 0]
    assert ends.min() == pytest.approx(0.4 + 0.1 + 2.4)  # the end of the jib
    assert ends.max() == pytest.approx(0.4 + 0.1 + 2.4 + 0.9 + 0.5)


def test_a_heavy_first_link_is_an_upper_structure_and_a_light_one_a_column():
    crane = small_crane()
    column = next(body for body in layout_drawing(crane).bodies if body.spots[0].link == "column")
    assert column.fill == OF_RUN
    heavy = crane._replace(links=(crane.links[0]._replace(mass=3000.0), *crane.links[1:]))
    bodies = [body for body in layout_drawing(heavy).bodies if body.spots[0].link == "column"]
    assert len(bodies) == 5
    assert all(body.fill != OF_RUN for body in bodies)


@pytest.mark.parametrize("scale", [0.05, 1.0, 20.0])
def test_everything_follows_the_machines_size(scale):
    """A machine of other size is the same picture on another scale."""

    def larger(point):
        return {c: scale * value for c, value in point.items()}

    crane = small_crane()._replace(chassis=None)
    links = tuple(link._replace(at=larger(link.at), cg=larger(link.cg)) for link in crane.links)
    lift = crane.functions[1]
    lift = lift._replace(pins=lift.pins._replace(base=larger(lift.pins.base), rod=larger(lift.pins.rod)))
    reach = crane.functions[2]
    reach = reach._replace(stops=reach.stops._replace(high=scale * reach.stops.high))
    other = crane._replace(
        links=links, functions=(crane.functions[0], lift, reach), tip=(crane.tip[0], larger(crane.tip[1]))
    )
    drawn, at_one = layout_drawing(other), layout_drawing(crane)
    assert drawn.ground == pytest.approx(scale * at_one.ground)
    assert drawn.rams[0].barrel == pytest.approx(scale * at_one.rams[0].barrel)
    for body, first in zip(drawn.bodies, at_one.bodies, strict=True):
        assert body.radii == pytest.approx([scale * radius for radius in first.radii])
        assert np.array([spot.at for spot in body.spots]) == pytest.approx(
            scale * np.array([spot.at for spot in first.spots]), abs=1e-9
        )
    reach = np.hypot(0.1, 1.9) + 2.4 + 1.1 + np.hypot(0.5, 0.2)  # column, jib, extension, tip
    assert scale * reach / 30.0 < drawn.scale <= scale * reach / 3.0


def test_a_link_that_carries_nothing_ends_behind_its_centre_of_gravity():
    crane = small_crane()
    boom = crane._replace(tip=("jib", {"x": 1.0}))
    body = next(body for body in layout_drawing(boom).bodies if body.spots[0].link == "extension")
    assert (0.6, 0.0, 0.0) in [spot.at for spot in body.spots]  # twice its centre of gravity


def test_a_bucket_has_its_shell_where_its_weight_is():
    machine = load_machine("cat215b_bucket")
    for height in (0.4, -0.4):
        bucket = machine.links[3]._replace(cg={"x": 0.5, "z": height})
        shell = max(
            (b for b in layout_drawing(machine._replace(links=(*machine.links[:3], bucket))).bodies
             if b.spots[0].link == "bucket" and b.views == ("side",) and not b.radii),
            key=lambda b: len(b.spots),
        )  # fmt: skip
        assert np.mean([spot.at[2] for spot in shell.spots]) * height > 0.0


@pytest.mark.parametrize("name", ["cat215b", "cat215b_bucket", "loader_crane", "wheel_loader"])
def test_what_the_side_view_shows_has_a_breadth_in_space(name):
    drawing = layout_drawing(load_machine(name))
    for body in drawing.bodies:
        assert bool(body.across) == ("side" in body.views)
        assert all(low < high for low, high in body.across)


def test_the_cab_is_on_the_left():
    """Where y is positive; its panes stand a little out of its walls."""
    bodies = layout_drawing(load_machine("cat215b")).bodies
    (cab,) = [body.across for body in bodies if body.fill == CAB]
    (glass,) = [body.across for body in bodies if body.fill == GLASS and "side" in body.views]
    assert cab[0][0] > 0.0
    assert glass[0][0] < cab[0][0] < cab[0][1] < glass[0][1]


@pytest.mark.parametrize("name", machine_names())
def test_the_ground_is_where_the_file_says_that_the_machine_stands(name):
    machine = load_machine(name)
    drawn = layout_drawing(machine)
    assert drawn.ground == min(z for _, _, z in machine.chassis.corners)
    still = [spot.at[2] for body in drawn.bodies for spot in body.spots if spot.link == PLANE and "side" in body.views]
    assert min(still) == pytest.approx(drawn.ground)  # tracks, or the block, go down to it
