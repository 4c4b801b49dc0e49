import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.networks import Split, grid
from polydraulic.networks.model.partition import box_name, choose, flatten, networks_of, region_boxes, region_of

EDGES = {0: (1.0,), 2: (0.0, 5.0)}


@st.composite
def partitions(draw, n_input=2):
    """A tree with up to six leaves, cut at whole numbers inside the leaf that is cut."""
    tree = 0
    for number in range(1, draw(st.integers(1, 6))):
        boxes = region_boxes(tree, n_input)
        k = draw(st.sampled_from(sorted(boxes)))
        axis = draw(st.integers(0, n_input - 1))
        low, high = np.clip(boxes[k][axis], -100, 100)
        at = 0.5 * (low + high)
        tree = replaced(tree, k, Split(axis, at, k, number))
    return tree


def replaced(tree, k, split):
    if not isinstance(tree, Split):
        return split if tree == k else tree
    return Split(tree.axis, tree.at, replaced(tree.below, k, split), replaced(tree.above, k, split))


def test_cells_of_a_grid_in_numbers_and_words():
    X = np.array([[0.0, 9.0, -1.0], [1.0, 9.0, 5.0], [2.0, 9.0, 6.0], [2.0, 9.0, 0.0]])
    assert networks_of(grid(EDGES)) == [0, 1, 2, 3, 4, 5]
    assert region_of(grid(EDGES), X).tolist() == [0, 1, 5, 3]
    names = [box_name(box, "pqr") for box in region_boxes(grid(EDGES), 3).values()]
    assert names[1] == "p in (-inf, 1] and r in (0, 5]"
    assert names[5] == "p in (1, inf) and r in (5, inf)"
    assert box_name(np.array([[-np.inf, np.inf]]), "p") == "everywhere"
    assert grid({}) == 0


def test_a_grid_is_balanced():
    assert flatten(grid({0: range(15)})).depth == 4


@given(partitions(), st.integers(0, 3))
def test_compiled_choice_rows_and_boxes_agree(tree, first):
    X = np.vstack([np.random.default_rng(0).uniform(-120, 120, size=(60, 2)), np.zeros((1, 2)), np.full((1, 2), 50.0)])
    regions, rows, boxes = flatten(tree, first), region_of(tree, X), region_boxes(tree, 2)
    for x, k in zip(X, rows, strict=True):
        assert choose(regions, x) == first + k
        assert [n for n, box in boxes.items() if np.all((box[:, 0] < x) & (x <= box[:, 1]))] == [k]
