"""What a machine stands on: what is read and refused, corners in their order, directions in which it tips, and the ground's slope."""

import math

import pytest

from helpers.small_crane import crane_text
from polydraulic import InputError, load_machine
from polydraulic.parameters.layout.chassis import edge_names
from polydraulic.parameters.layout.describe import described
from polydraulic.parameters.layout.usual import unusual

STANDS = """
[chassis]
mass = { value = 900, unit = "kg", source = "s" }
cg.x = { value = -200, unit = "mm", source = "s" }
contacts.a.x = { value = 1, unit = "m", source = "s" }
contacts.a.y = { value = -1, unit = "m", source = "s" }
contacts.b.x = { value = -1.2, unit = "m", source = "s" }
contacts.c.x = { value = 100, unit = "cm", source = "s" }
contacts.c.y = { value = 1, unit = "m", source = "s" }
slope.pitch = { value = 10, unit = "deg", source = "s" }
slope.roll = { value = 0, unit = "deg", source = "s" }
"""
TRACKS = 'tracks = { gauge = { value = 2, unit = "m", source = "s" }, length = { value = 3, unit = "m", source = "s" }, at = { x = { value = 0.1, unit = "m", source = "s" } } }\n'


def crane(folder, text=STANDS):
    path = folder / "crane.toml"
    path.write_text(crane_text() + text, encoding="utf-8")
    return load_machine(path)


def test_corners_stand_counter_clockwise_whatever_the_order_in_the_file(tmp_path):
    chassis = crane(tmp_path).chassis
    assert chassis.corners == ((1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.2, 0.0, 0.0))
    assert edge_names(chassis) == ("forward", "rear left", "rear right")
    assert (chassis.mass, chassis.cg) == (900.0, {"x": -0.2})


def test_tracks_are_a_rectangle(tmp_path):
    contacts = STANDS[STANDS.index("contacts.a.x") : STANDS.index("slope")]
    chassis = crane(tmp_path, STANDS.replace(contacts, TRACKS)).chassis
    x = 0.1
    assert chassis.corners == ((x + 1.5, -1.0, 0.0), (x + 1.5, 1.0, 0.0), (x - 1.5, 1.0, 0.0), (x - 1.5, -1.0, 0.0))
    assert edge_names(chassis) == ("forward", "left", "rear", "right")


def test_edges_in_one_direction_are_numbered(tmp_path):
    more = STANDS + 'contacts.d.x = { value = 1.4, unit = "m", source = "s" }\n'
    assert edge_names(crane(tmp_path, more).chassis) == ("forward 1", "forward 2", "rear left", "rear right")


def test_upward_leans_towards_where_the_ground_rises(tmp_path):
    x, y, z = crane(tmp_path).chassis.upward
    assert (x, y, z) == pytest.approx((math.sin(math.radians(10)), 0.0, math.cos(math.radians(10))))


def test_numbers_of_a_chassis_have_paths_and_can_be_changed(tmp_path):
    machine = crane(tmp_path)
    paths = [n.path for n in machine.numbers if n.path.startswith("chassis")]
    assert paths == [
        "chassis.mass", "chassis.cg.x", "chassis.contacts.a.x", "chassis.contacts.a.y", "chassis.contacts.b.x", "chassis.contacts.c.x",
        "chassis.contacts.c.y", "chassis.slope.pitch", "chassis.slope.roll",
    ]  # fmt: skip
    heavy = machine.with_values({"chassis.mass": 1000.0, "chassis.contacts.b.x": -2.0})
    assert heavy.chassis.mass == 1000.0
    assert heavy.chassis.corners[2] == (-2.0, 0.0, 0.0)
    with pytest.raises(InputError, match="no corner of the area"):
        machine.with_values({"chassis.contacts.b.x": 1.0})


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('mass = { value = 900, unit = "kg"', 'mass = { value = 0, unit = "kg"', "chassis.mass"),
        ('mass = { value = 900, unit = "kg", source = "s" }', "", "missing key 'mass' in chassis"),
        ("contacts.b.x = { value = -1.2", "contacts.b.x = { value = 1", "no corner of the area between them"),
        ("slope.pitch = { value = 10,", "slope.pitch = { value = 50,", "chassis.slope.pitch"),
        ("contacts.a.y", TRACKS + "contacts.a.y", "give either tracks (gauge and length) or contacts"),
        ('contacts.b.x = { value = -1.2, unit = "m", source = "s" }', "", "chassis.contacts: 2 of them; must be 3 to 8"),
        ("cg.x", "cg.r", "unknown key 'r'"),
        ("slope.roll", "slope.yaw", "unknown key 'yaw'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(tmp_path, old, new, words):
    assert old in STANDS
    with pytest.raises(InputError) as error:
        crane(tmp_path, STANDS.replace(old, new))
    assert words in str(error.value)


def test_what_is_unusual_is_named_and_all_of_it_described(tmp_path):
    assert unusual(crane(tmp_path)) == []
    text = "\n".join(described(crane(tmp_path)))
    assert "900 kg that no joint moves" in text
    assert "rises by 10 deg along x and 0 deg along y" in text
    found = unusual(crane(tmp_path, STANDS.replace("value = 900", "value = 9")))
    assert [line.split(":")[0] for line in found] == ["chassis.mass = 9 kg"]
