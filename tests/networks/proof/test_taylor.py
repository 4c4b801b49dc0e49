from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.exact import exact_output
from polydraulic.networks import Network, Node
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, RAMP, SIGMOID, SINGLE, TRIPLE, terms
from polydraulic.networks.model.table import used_slots
from polydraulic.networks.proof.taylor import Form, enclose_output, enclose_slopes, layout

number = st.floats(-2.0, 2.0).map(lambda v: round(v, 3))


@st.composite
def chains(draw):
    """Networks in which every node reads the one before it."""
    n_input = draw(st.integers(1, 4))
    nodes = []
    for k, kind in enumerate(
        draw(st.lists(st.sampled_from([SINGLE, DOUBLE, TRIPLE, LINEAR, SIGMOID, RAMP]), min_size=1, max_size=3))
    ):
        size = kind + 1 if kind < LINEAR else draw(st.integers(1, 3))
        slots = draw(
            st.permutations([n_input + k - 1, *(draw(st.integers(0, n_input + k - 1)) for _ in range(size - 1))])
        )
        nodes.append(Node(kind, tuple(slots), tuple(draw(number) for _ in terms(kind, size))))
    mean, scale = (tuple(draw(st.floats(0.5, 3.0)) for _ in range(n_input)) for _ in range(2))
    return Network(
        tuple(nodes), mean, scale, (-1.0,) * n_input, (1.5,) * n_input, draw(number), draw(st.floats(0.1, 3.0))
    )


def is_enclosed(form, e, value):
    """Whether `value` lies as near the polynomial at `e` as the form promises; reading it takes some rounding too."""
    near = float(form.polynomial(e)[0])
    return abs(value - Fraction(near)) <= Fraction(float(form.error[0] + 1e-14 * form.size[0]))


def assert_enclosed(network, width):
    """Compare output and slopes with exact ones at points of a cube."""
    used, _ = used_slots(network)
    middle = np.full((len(used), 1), 0.25)
    low, high = middle - 0.5 * width, middle + 0.5 * width
    output, slopes = enclose_output(network, low, high), enclose_slopes(network, low, high)
    tiny = Fraction(1, 10**30)
    for e in np.random.default_rng(0).uniform(-1.0, 1.0, size=(4, len(used), 1)):
        e = np.where(np.abs(e) > 0.5, np.sign(e), e)
        x = [Fraction(0)] * network.n_inputs
        for i, place in zip(used, e[:, 0], strict=True):
            x[i] = Fraction(1, 4) + Fraction(width) / 2 * Fraction(place)
        value = exact_output(network, x)
        assert is_enclosed(output, e, value)
        for i, slope in zip(used, slopes, strict=True):
            moved = [a + tiny * (k == i) for k, a in enumerate(x)]
            assert is_enclosed(slope, e, (exact_output(network, moved) - value) / tiny)


@settings(max_examples=40)
@given(chains(), st.sampled_from([2.0, 0.5, 0.02]))
def test_output_and_slopes_lie_within_the_errors_of_their_polynomials(network, width):
    assert_enclosed(network, width)


@pytest.mark.parametrize("seed", range(8))
def test_errors_are_carried_through_deep_networks(seed):
    # Degree 27 in one input, 9 in four: more than the polynomials keep.
    rng = np.random.default_rng(seed)
    nodes = [Node(SINGLE, (k,), tuple(rng.normal(size=4))) for k in (0, 1, 2)]
    assert_enclosed(Network(tuple(nodes), (0.0,), (1.0,), (-1.0,), (1.5,), 0.0, 1.0), 2.0)
    slots = ((0, 1, 2), (3, 4, 2), (5, 4, 0))
    nodes = [Node(TRIPLE, at, tuple(rng.normal(size=14))) for at in slots]
    assert_enclosed(Network(tuple(nodes), (0.0,) * 4, (1.0,) * 4, (-1.0,) * 4, (1.5,) * 4, 0.0, 1.0), 0.5)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4, 7])
def test_a_product_is_the_product_of_the_polynomials_within_its_error(n):
    rng = np.random.default_rng(n)
    at = layout(n)
    a, b = (Form(rng.normal(size=(len(at.target), 5)), np.zeros(5), at) for _ in range(2))
    product = a * b
    assert len(set(zip(at.parent[1:], at.axis[1:], strict=True))) == len(at.target) - 1
    for e in rng.uniform(-1.0, 1.0, size=(20, n, 5)):
        assert np.all(np.abs(product.polynomial(e) - a.polynomial(e) * b.polynomial(e)) <= product.error)
    # To the order that is kept nothing is lost: the rest vanishes faster than any kept power.
    small = 1e-3 * rng.uniform(-1.0, 1.0, size=(n, 5))
    lost = np.abs(product.polynomial(small) - a.polynomial(small) * b.polynomial(small))
    assert np.all(lost <= 1e-9 * product.size)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_ends_are_below_and_above_all_values_and_near_quadratic_ones(n):
    rng = np.random.default_rng(n)
    at = layout(n)
    poly = rng.normal(size=(len(at.target), 50))
    e = rng.uniform(-1.0, 1.0, size=(400, n, 1))
    form = Form(poly, np.full(50, 0.1), at)
    values = np.array([form.polynomial(np.tile(point, 50)) for point in e])
    assert np.all(form.lower()[0] <= values.min(axis=0) - 0.1)
    assert np.all(form.upper()[0] >= values.max(axis=0) + 0.1)
    poly[2 * n + 1 :] = 0.0
    form = Form(poly, np.zeros(50), at)
    for bound, place in (form.lower(), form.upper()):
        assert bound == pytest.approx(form.polynomial(place), abs=1e-12)


def test_more_inputs_take_a_lower_order():
    orders = [layout(n).degree.size - 1 for n in (1, 2, 3, 4, 6, 7, 30)]
    assert orders == [8, 8, 5, 4, 3, 2, 2]


def test_inputs_without_a_way_to_the_output_are_not_used():
    nodes = (
        Node(SINGLE, (0,), (0.0, 1.0, 0.0, 0.0)),
        Node(SINGLE, (2,), (0.0, 1.0, 0.0, 0.0)),
        Node(SINGLE, (4,), (0.0, 1.0, 0.0, 0.0)),
    )
    assert used_slots(Network(nodes, (0.0,) * 3, (1.0,) * 3, (0.0,) * 3, (1.0,) * 3, 0.0, 1.0)) == ([2], [1, 2])
