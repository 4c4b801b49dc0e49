"""Files of the older form are read as machines of links, functions and circuits, and refused in their own words."""

from pathlib import Path

import pytest

from polydraulic import InputError, load_machine, simulate
from polydraulic.parameters.layout.schema import LayoutMachine

FILE = Path(__file__).parent / "data" / "cat215b_older.toml"


def test_the_older_form_of_cat215b_has_the_same_numbers_in_every_bit():
    older, shipped = load_machine(FILE), load_machine("cat215b")
    assert isinstance(older, LayoutMachine)
    for part in ("gravity", "tank", "functions", "circuits", "tip"):
        assert getattr(older, part) == getattr(shipped, part), part
    swing, *others = older.links
    assert others == list(shipped.links[1:])
    upper = shipped.links[
        0
    ]  # the older form knows its inertia about the upright axis alone, and nothing that moves depends on more
    assert swing == upper._replace(mass=0.0, cg={}, inertia={"zz": 18000.0})
    assert upper.inertia["zz"] + upper.mass * upper.cg["x"] ** 2 == 18000.0
    assert older.title == "cat215b_older"


@pytest.mark.slow
def test_a_run_of_it_is_that_of_the_shipped_file():
    older, shipped = (simulate(machine, "exact", "task", t_end=1.0) for machine in (FILE, "cat215b"))
    assert all((older[name] == shipped[name]).all() for name in shipped.names)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[boom.pilot]\ngain", "[boom.pilot]\ngian", r"unknown key 'gian' in boom.pilot"),
        ("low = { value = -40.0", "low = { value = 70.0", r"boom.stops.low = 70.*: must be below stops.high"),
        ("mass = { value = 1500.0", "mass = { value = -2.0", "boom.body.mass = -2.0 kg: must be"),
        ("angle_offset = { value = 62.0", "angle_offset = { value = 20.0", "boom.*the linkage turns over"),
        (
            "r_base = { value = 0.75",
            "r_base = { value = -1.0",
            "boom.cylinder.r_base = -1.0 m: must be above 0 m",
        ),
        ("[geometry]", "[geometrie]", "unknown key 'geometrie'; allowed here: "),
        ("[tank]", "[[tank]]", "tank must be a table, not"),
    ],
)
def test_what_is_wrong_is_said_in_the_words_of_the_file(tmp_path, old, new, message):
    text = FILE.read_text()
    assert old in text
    (tmp_path / "mine.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=f"(?s)mine.toml: .*{message}") as error:
        load_machine(tmp_path / "mine.toml")
    assert "functions." not in str(error.value)
    assert "links." not in str(error.value)
