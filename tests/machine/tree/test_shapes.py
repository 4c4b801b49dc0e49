import pytest

from helpers.trees import excavator
from polydraulic.errors import InputError
from polydraulic.machine.tree.links import Link
from polydraulic.machine.tree.shapes import links_of_shape, shape_of


def test_a_shape_is_what_is_declared_in_one_order():
    link = Link("arm", None, "revolute", "-y", {"z": 0.0, "x": 1.0}, 3.0, {}, {"yz": 0.0, "xx": 1.0})
    shape = shape_of(link)
    assert shape == ("arm", None, "revolute", "-y", ("x", "z"), True, (), ("xx", "yz"))
    assert shape == shape_of(link._replace(mass=7.0, at={"x": 5.0, "z": 6.0}))
    assert shape_of(link._replace(mass=None)).mass is False


def test_numbers_become_floats():
    links = [Link("arm", None, "revolute", "y", {"x": 1}, 3, {"x": 2}, {"yy": 4})]
    arm = links_of_shape(links, [shape_of(link) for link in links])["arm"]
    values = [arm.mass, *arm.at.values(), *arm.cg.values(), *arm.inertia.values()]
    assert values == [3.0, 1.0, 2.0, 4.0]
    assert {type(value) for value in values} == {float}


def test_links_of_another_shape_are_refused():
    links = excavator()
    shapes = [shape_of(link) for link in links]
    assert list(links_of_shape(links, shapes)) == ["swing", "boom", "stick"]
    with pytest.raises(InputError, match=r"link boom: the equations of motion are written for .*at=\('x', 'y'\)"):
        links_of_shape([link._replace(at={"x": 1.0}) if link.name == "boom" else link for link in links], shapes)
    with pytest.raises(InputError, match="2 links for equations of motion of 3"):
        links_of_shape(links[:2], shapes)
