import numpy as np

from polydraulic.networks.model.partition import Split
from polydraulic.networks.regions.tree import Halves, Leaf, box_halves, grow_tree

BOX = np.array([[0.0, 8.0], [0.0, 1.0]])


def leaf(box, cost):
    return Leaf(box, f"fit of {box[0, 0]:g} to {box[0, 1]:g}", cost, False)


def halve(one):
    """Cut in the middle of the first input; narrow regions stay."""
    low, high = one.box[0]
    if high - low < 2.0:
        return None
    below, above = box_halves(one.box, 0, (low + high) / 2.0)
    return Halves(0, (low + high) / 2.0, leaf(below, one.cost / 2.0), leaf(above, one.cost / 4.0))


def test_the_costliest_region_is_cut_until_there_are_enough():
    partition, leaves = grow_tree(0, [leaf(BOX, 8.0)], halve, 3)
    assert partition == Split(0, 4.0, Split(0, 2.0, 0, 1), 2)
    assert [one.box[0].tolist() for one in leaves] == [[0.0, 2.0], [2.0, 4.0], [4.0, 8.0]]
    assert [one.cost for one in leaves] == [2.0, 1.0, 2.0]


def test_regions_that_cannot_be_cut_are_left():
    partition, leaves = grow_tree(0, [leaf(BOX, 8.0)], halve, 100)
    assert len(leaves) == 8
    assert all(one.settled for one in leaves)
    assert [one.box[0, 0] for one in leaves] == list(range(8))
    assert isinstance(partition, Split)


def test_what_is_settled_stays_as_it_is():
    start = [leaf(BOX, 1.0)._replace(settled=True)]
    assert grow_tree(0, start, halve, 5) == (0, start)


def test_halves_share_the_cut_and_leave_the_box_alone():
    below, above = box_halves(BOX, 1, 0.25)
    assert below.tolist() == [[0.0, 8.0], [0.0, 0.25]]
    assert above.tolist() == [[0.0, 8.0], [0.25, 1.0]]
    assert BOX[1].tolist() == [0.0, 1.0]
