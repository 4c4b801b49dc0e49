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


def cells(*holes):
    """A row in the middle of every cell of a map, but for those in holes: cells from, cells to."""
    x, y = np.divmod(np.arange(100), 10)
    keep = np.ones(100, dtype=bool)
    for (a, b), (c, d) in holes:
        keep &= ~((x >= a) & (x < b) & (y >= c) & (y < d))
    table = Table({"x": (x[keep] + 0.5) / 10.0, "y": (y[keep] + 0.5) / 10.0}, {})
    return coverage(table, ["x", "y"], {"x": (0.0, 1.0), "y": (0.0, 1.0)}).pairs[0]


def test_a_hole_is_named_from_a_twenty_fifth_of_the_map_on():
    assert [hole.share for hole in cells(((2, 4), (5, 7))).holes] == [0.04]
    found = cells(((2, 5), (5, 6)))
    assert (found.holes, found.share) == ([], 0.97)
    assert found.counts.shape == (10, 10)
    assert set(found.counts.flat) == {0, 1}


def test_the_three_largest_holes_are_named_the_largest_first():
    found = cells(((0, 2), (0, 2)), ((3, 6), (3, 6)), ((0, 2), (7, 10)), ((7, 10), (0, 2)), ((8, 10), (8, 10)))
    assert [round(hole.share, 2) for hole in found.holes] == [0.09, 0.06, 0.06]
    assert (*found.holes[0].x, *found.holes[0].y) == pytest.approx((0.3, 0.6, 0.3, 0.6))
    assert {(round(h.x[0], 1), round(h.y[0], 1)) for h in found.holes[1:]} == {(0.0, 0.7), (0.7, 0.0)}


def test_holes_do_not_overlap():
    first, second = cells(((0, 2), (0, 10)), ((0, 10), (0, 2))).holes  # an L
    assert (first.share, second.share) == (0.2, 0.16)


def test_the_largest_hole_of_all_maps_is_told_first():
    x, y = np.random.default_rng(0).uniform(0.0, 1.0, (2, 40_000))
    z = np.random.default_rng(1).uniform(0.0, 1.0, 40_000)
    keep = ~((x > 0.4) & (y > 0.5)) & ~((y < 0.2) & (z < 0.2))
    table = Table({"x": x[keep], "y": y[keep], "z": z[keep]}, {})
    box = dict.fromkeys("xyz", (0.0, 1.0))
    found = coverage(table, ["x", "y", "z"], box)
    assert [(pair.x, pair.y) for pair in found.pairs] == [("x", "y"), ("x", "z"), ("y", "z")]
    told = found.statements({})
    assert told == [
        "no rows with x 0.4 to 1 and y 0.5 to 1 (30% of their map)",
        "no rows with y 0 to 0.2 and z 0 to 0.2 (4% of their map)",
    ]
    assert found.box == box


def test_cells_of_the_whole_box_are_quarters_and_hold_their_ends():
    ends = Table({"x": np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.01, -0.01])}, {})
    assert coverage(ends, ["x"], {"x": (0.0, 1.0)}).visited == 4
    low = Table({"x": np.array([0.0, 0.2499])}, {})
    assert coverage(low, ["x"], {"x": (0.0, 1.0)}).visited == 1
    top = Table({"x": np.array([0.75, 1.0])}, {})
    assert coverage(top, ["x"], {"x": (0.0, 1.0)}).visited == 1
    grid = np.array([(a, b) for a in (0.1, 0.4, 0.6, 0.9) for b in (0.1, 0.4, 0.6, 0.9)])
    both = Table({"x": grid[:, 0], "y": grid[:, 1]}, {})
    assert coverage(both, ["x", "y"], {"x": (0.0, 1.0), "y": (0.0, 1.0)}).visited == 16


def test_of_many_inputs_thirty_are_counted():
    table = Table({f"x{i}": np.array([0.0, 1.0]) for i in range(31)}, {})
    found = coverage(table, list(table.names))
    assert (found.cells, found.visited, len(found.pairs)) == (4**30, 2, 31 * 30 // 2)


def test_a_box_begins_anywhere():
    table = Table({"x": np.array([10.5, 11.5, 12.5, 13.5]), "y": np.array([-4.0, -3.0, -2.0, -1.0])}, {})
    found = coverage(table, ["x", "y"], {"x": (10.0, 14.0)})
    assert (found.visited, found.names, found.box) == (4, ["x", "y"], {"x": (10.0, 14.0), "y": (-4.0, -1.0)})
    assert found.pairs[0].x_edges == pytest.approx(np.linspace(10.0, 14.0, 11))
    assert found.pairs[0].y_edges == pytest.approx(np.linspace(-4.0, -1.0, 11))
    outside = {"x": (10.0, 13.0), "y": (-3.5, -1.0)}  # the first row by one input, the last by the other
    assert coverage(table, ["x", "y"], outside).visited == 2


def test_one_row_is_a_box_of_hardly_any_size():
    found = coverage(Table({"x": np.array([3.0]), "y": np.array([5e6])}, {}), ["x", "y"])
    assert found.visited == 1
    assert 0.0 < np.ptp(found.pairs[0].x_edges) < 1e-8
    assert 0.0 < np.ptp(found.pairs[0].y_edges) < 1e-2
