import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure import conversion, coverage
from polydraulic.tables import Table


def square(n=20_000, hole=lambda x, y: np.zeros(len(x), dtype=bool)):
    x, y = np.random.default_rng(0).uniform(0.0, 1.0, (2, n))
    keep = ~hole(x, y)
    return Table({"x": x[keep], "y": y[keep]}, {"x": "m", "y": "Pa"})


def test_a_full_box_has_no_holes():
    found = coverage(square(), ["x", "y"])
    assert (found.visited, found.cells) == (16, 16)
    assert found.pairs[0].share == 1.0
    assert found.pairs[0].counts.sum() == 20_000
    assert found.statements({}) == []


def test_a_hole_is_named_where_it_is():
    table = square(hole=lambda x, y: (x > 0.3) & (x < 0.7) & (y > 0.6))
    found = coverage(table, ["x", "y"], {"x": (0.0, 1.0), "y": (0.0, 1.0)})
    (hole,) = found.pairs[0].holes
    assert (*hole.x, *hole.y, hole.share) == pytest.approx((0.3, 0.7, 0.6, 1.0, 0.16))
    assert found.pairs[0].share == pytest.approx(0.84)
    shown = found.statements({"x": conversion("mm"), "y": conversion("Pa")})
    assert shown == ["no rows with x 300 to 700 mm and y 0.6 to 1 Pa (16% of their map)"]


def test_rows_outside_of_the_box_do_not_count_and_empty_parts_of_it_are_holes():
    found = coverage(square(), ["x", "y"], {"x": (0.0, 2.0), "y": (0.0, 0.5)})
    assert found.pairs[0].holes[0].x == pytest.approx((1.0, 2.0))
    assert found.visited == 8
    assert found.pairs[0].counts.sum() < 11_000


def test_one_input_has_no_pairs():
    found = coverage(square(), ["x"])
    assert (found.pairs, found.visited, found.cells) == ([], 4, 4)


def test_a_constant_input_takes_one_cell():
    table = Table({"x": np.linspace(0.0, 1.0, 100), "y": np.full(100, 5.0)}, {})
    assert coverage(table, ["x", "y"]).visited == 4


@pytest.mark.parametrize(
    ("names", "box", "message"),
    [([], {}, "needs inputs"), (["x"], {"x": (1.0, 0.0)}, "low must lie below"), (["z"], {}, "no column 'z'")],
)
def test_bad_arguments_are_named(names, box, message):
    with pytest.raises(InputError, match=message):
        coverage(square(100), names, box)
