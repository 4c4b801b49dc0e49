from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from helpers.exact import exact_output
from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Model, Network, Node, Variable, grid
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, RAMP, SIGMOID, SINGLE, TRIPLE, terms
from polydraulic.networks.model.table import UNBOUNDED
from polydraulic.networks.proof.bounds import check_range, model_bounds, network_bounds

PRODUCT = Node(DOUBLE, (0, 1), (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0))
number = st.floats(-2.0, 2.0).map(lambda v: round(v, 3))


@st.composite
def networks(draw, n_input=None):
    n_input = n_input or draw(st.integers(1, 3))
    nodes = []
    for k in range(draw(st.integers(0, 3))):
        kind = draw(st.sampled_from([SINGLE, DOUBLE, TRIPLE, LINEAR, SIGMOID, RAMP]))
        size = kind + 1 if kind < LINEAR else draw(st.integers(1, 4))
        # The last node reads the one before, so that most nodes matter.
        slots = [draw(st.integers(0, n_input + k - 1)) for _ in range(size)]
        slots[0] = n_input + k - 1
        nodes.append(Node(kind, tuple(slots), tuple(draw(number) for _ in terms(kind, size))))
    bounded = draw(st.booleans())
    return Network(
        nodes=tuple(nodes),
        x_mean=tuple(draw(number) for _ in range(n_input)),
        x_scale=tuple(draw(st.floats(0.5, 3.0)) for _ in range(n_input)),
        x_low=tuple(-1.0 for _ in range(n_input)),
        x_high=tuple(1.5 for _ in range(n_input)),
        y_mean=draw(number),
        y_scale=draw(st.floats(0.1, 3.0)),
        y_low=-5.0 if bounded else -1e300,
        y_high=4.0 if bounded else 1e300,
    )


@st.composite
def boxes(draw, n_input, low=-2.0, high=2.5):
    ends = st.floats(low, high).map(lambda v: round(v, 2))
    return np.sort([[draw(ends), draw(ends)] for _ in range(n_input)], axis=1) + 0.0  # no negative zeros


def model_of(*found, edges=None, unit=""):
    inputs = tuple(Variable(f"x{i}") for i in range(found[0].n_inputs))
    return Model(inputs, Variable("y", unit), found, grid(edges or {}))


def predict(network, X):
    return model_of(network).predict(X)


def attack(box, rng):
    """Random points, corners, and points of every face."""
    n = len(box)
    X = rng.uniform(box[:, 0], box[:, 1], size=(200, n))
    faces = np.where(rng.random((200, n)) < 0.5, X, box[np.arange(n), rng.integers(0, 2, (200, n))])
    return np.vstack([np.clip(X, box[:, 0], box[:, 1]), faces, list(product(*box))])


def single(*coef, low=-1.0, high=1.0, **bounds):
    return Network((Node(SINGLE, (0,), coef),), (0.0,), (1.0,), (low,), (high,), 0.0, 1.0, **bounds)


@settings(max_examples=40)
@given(st.data())
def test_no_point_of_the_box_leaves_the_proved_range(data):
    network = data.draw(networks())
    box = data.draw(boxes(network.n_inputs))
    found = network_bounds(network, box, max_boxes=data.draw(st.sampled_from([1, 9, 40])))
    y = predict(network, attack(box, np.random.default_rng(0)))
    assert found.low <= y.min()
    assert y.max() <= found.high
    for where, value in ((found.where_low, found.attained_low), (found.where_high, found.attained_high)):
        assert np.all((box[:, 0] <= where) & (where <= box[:, 1]))
        assert predict(network, where[None])[0] == value
    assert found.low <= found.attained_low <= found.attained_high <= found.high


@settings(max_examples=25)
@given(st.data())
def test_exact_values_and_secants_lie_in_the_proved_ranges(data):
    network = data.draw(networks())
    box = data.draw(boxes(network.n_inputs, -1.0, 1.5))
    found = network_bounds(network, box, max_boxes=9)
    rng = np.random.default_rng(1)
    for x in rng.uniform(box[:, 0], box[:, 1], size=(4, network.n_inputs)):
        x = np.clip(x, box[:, 0], box[:, 1])
        assert found.low <= min(max(exact_output(network, x), network.y_low), network.y_high) <= found.high
        for i in range(network.n_inputs):
            # A secant is the slope somewhere between its ends.
            low, high = (np.where(np.arange(x.size) == i, end, x) for end in box.T)
            if low[i] < high[i]:
                secant = (exact_output(network, high) - exact_output(network, low)) / (
                    Fraction(high[i]) - Fraction(low[i])
                )
                assert found.slopes[i, 0] <= secant <= found.slopes[i, 1]


@pytest.mark.parametrize("seed", range(3))
def test_local_optimization_does_not_leave_the_proved_range_of_a_grown_network(seed):
    rng = np.random.default_rng(seed)
    X = rng.uniform(-1.0, 1.0, size=(300, 2))
    y = np.sin(3.0 * X[:, 0]) * np.exp(X[:, 1]) + 0.05 * rng.normal(size=300)
    network = AbductiveRegressor(max_layers=2).fit(X, y).network_
    found = network_bounds(network)
    box = np.column_stack([network.x_low, network.x_high])
    assert found.converged
    width = found.attained_high - found.attained_low
    assert found.high - found.attained_high <= 0.0101 * width
    assert found.attained_low - found.low <= 0.0101 * width
    for sign, start in ((1.0, found.where_low), (-1.0, found.where_high)):
        for x0 in (start, *rng.uniform(box[:, 0], box[:, 1], size=(2, 2))):
            best = minimize(lambda x, s=sign: s * predict(network, x[None])[0], x0, method="Nelder-Mead", bounds=box)
            assert found.low <= sign * best.fun <= found.high
    gradient = np.array([np.gradient(predict(network, line), line[:, i], axis=0)[1:-1] for i, line in lines(box)])
    assert np.all(found.slopes[:, :1] <= gradient.min(axis=1, keepdims=True) + 1e-6)
    assert np.all(gradient.max(axis=1, keepdims=True) <= found.slopes[:, 1:] + 1e-6)


def lines(box):
    middle = box.mean(axis=1)
    for i in range(len(box)):
        line = np.tile(middle, (200, 1))
        line[:, i] = np.linspace(*box[i], 200)
        yield i, line


def test_rounding_of_the_evaluation_is_covered():
    # Squares of two equal nodes that cancel: zero but for rounding.
    one = (0.3, 1.1, -0.7, 0.2)
    square = (0.0, 0.0, 0.0, 1e8, 3e8, -4e8, 0.0, 0.0)
    nodes = (Node(SINGLE, (0,), one), Node(SINGLE, (0,), one), Node(DOUBLE, (1, 2), square))
    network = Network(nodes, (1e3,), (0.37,), (999.0,), (1001.0,), 0.0, 1.0)
    X = np.random.default_rng(0).uniform(999.0, 1001.0, size=(300, 1))
    y = predict(network, X)
    assert np.ptp(y) > 0.0
    found = network_bounds(network, max_boxes=200)
    assert found.low <= y.min() <= y.max() <= found.high
    for x, value in zip(X[:20], y[:20], strict=True):
        at = network_bounds(network, np.column_stack([x, x]), max_boxes=1)
        assert at.low <= value <= at.high
        assert at.high - at.low < 1e-3  # of terms above 1e9
        assert at.attained_low == value


def test_simple_ranges_are_those_of_calculus():
    constant = network_bounds(Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.5, 1.0))
    assert (constant.low, constant.high, constant.converged) == (2.5, 2.5, True)
    assert constant.slopes.tolist() == [[0.0, 0.0]]

    cubic = network_bounds(single(0.0, -1.0, 0.0, 1.0), tolerance=1e-9)
    assert [cubic.low, cubic.high] == pytest.approx([-2.0 / 27**0.5, 2.0 / 27**0.5], rel=1e-8)
    assert cubic.where_low == pytest.approx([3**-0.5], abs=1e-3)
    assert cubic.slopes[0] == pytest.approx([-1.0, 2.0], rel=1e-8)

    xy = network_bounds(Network((PRODUCT,), (0.0, 0.0), (1.0, 1.0), (-1.0, -3.0), (2.0, 4.0), 0.0, 1.0))
    assert [xy.low, xy.high] == pytest.approx([-6.0, 8.0], rel=1e-12)
    assert xy.slopes == pytest.approx(np.array([[-3.0, 4.0], [-1.0, 2.0]]), rel=1e-12)
    assert xy.where_low.tolist() == [2.0, -3.0]

    # Units: y = 10 + 5 (x - 3) / 2.
    line = Network((Node(LINEAR, (0,), (1.0,)),), (3.0,), (2.0,), (1.0,), (7.0,), 10.0, 5.0)
    found = network_bounds(line)
    assert [found.low, found.high, *found.slopes[0]] == pytest.approx([5.0, 20.0, 2.5, 2.5], rel=1e-12)


def test_inputs_are_clamped_to_the_domain():
    network = single(0.0, 1.0, 0.0, 0.0, high=1.0)
    outside = network_bounds(network, [[5.0, np.inf]])
    assert [outside.low, outside.high] == pytest.approx([1.0, 1.0], rel=1e-12)
    assert outside.where_low[0] == 5.0
    assert outside.slopes[0] == pytest.approx([0.0, 1.0], rel=1e-12)
    over = network_bounds(network, [[-np.inf, 0.5]])
    assert [over.low, over.high, *over.slopes[0]] == pytest.approx([-1.0, 0.5, 0.0, 1.0], rel=1e-12)
    assert network_bounds(network, [[0.0, 0.5]]).slopes[0] == pytest.approx([1.0, 1.0], rel=1e-12)


def test_an_idle_input_has_no_slope():
    network = Network((Node(SINGLE, (1,), (0.0, 1.0, 0.0, 0.0)),), (0.0,) * 2, (1.0,) * 2, (0.0,) * 2, (1.0,) * 2, 0, 1)
    assert network_bounds(network).slopes == pytest.approx(np.array([[0.0, 0.0], [1.0, 1.0]]))


def test_the_budget_ends_the_search_and_the_range_is_still_proved():
    waves = single(0.0, 3.0, 0.0, -4.0)  # the third Chebyshev polynomial, with the sign turned
    deep = Network(
        (waves.nodes[0], Node(SINGLE, (1,), waves.nodes[0].coef), Node(SINGLE, (2,), waves.nodes[0].coef)),
        (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0,
    )  # fmt: skip
    rough = network_bounds(deep, max_boxes=3)
    assert rough.n_boxes == 6
    assert not rough.converged
    assert rough.low < -1.5
    fine = network_bounds(deep)
    assert fine.converged
    assert [fine.low, fine.high] == pytest.approx([-1.0, 1.0], abs=0.021)
    assert rough.low <= fine.low
    slopes = -np.polynomial.Chebyshev.basis(27).deriv()(np.cos(np.linspace(0.0, np.pi, 20001)))
    assert fine.slopes[0] == pytest.approx([slopes.min(), slopes.max()], abs=0.011 * np.ptp(slopes))


def test_overflow_gives_an_infinite_range():
    network = Network(
        tuple(Node(SINGLE, (k,), (0.0, 0.0, 0.0, 1e150)) for k in range(3)),
        (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0, -1.0, 1.0,
    )  # fmt: skip
    found = network_bounds(network, max_boxes=50)
    assert (found.low, found.high, found.converged) == (-np.inf, np.inf, False)


def test_an_output_that_is_no_number_is_not_proved_to_be_one():
    nodes = (Node(SINGLE, (0,), (0.0, 0.0, 0.0, 1e300)), Node(LINEAR, (1, 1), (1e300, -1e300)))
    found = network_bounds(Network(nodes, (0.0,), (1.0,), (1e5,), (2e5,), 0.0, 1.0, -1.0, 1.0), max_boxes=9)
    assert (found.low, found.high, found.converged) == (-np.inf, np.inf, False)
    assert (found.attained_low, found.attained_high) == (np.inf, -np.inf)


def test_a_model_is_bounded_region_by_region():
    a, b, c = single(0.0, 1.0, 0.0, 0.0), single(5.0, 0.0, 0.0, 0.0), single(0.0, 2.0, 0.0, 0.0, high=3.0)
    model = model_of(a, b, c, edges={0: (0.0, 1.0)})
    found = model_bounds(model)
    assert [found.low, found.high] == pytest.approx([-1.0, 6.0], rel=1e-12)
    ranges = np.array([(region.low, region.high) for region in found.regions])
    assert ranges == pytest.approx(np.array([(-1.0, 0.0), (5.0, 5.0), (2.0, 6.0)]))
    part = model_bounds(model, [[-0.5, 0.0]])  # an edge belongs to the region below
    assert [r is None for r in part.regions] == [False, True, True]
    part = model_bounds(model, [[0.5, 1.5]])
    assert [r is None for r in part.regions] == [True, False, False]
    # Beyond its domain a region sees the border.
    assert model_bounds(model, [[2.0, 9.0]]).high == pytest.approx(6.0)


@settings(max_examples=20)
@given(st.data())
def test_no_point_leaves_the_proved_range_of_a_model(data):
    first = data.draw(networks())
    others = [data.draw(networks(first.n_inputs)) for _ in range(2)]
    model = model_of(first, *others, edges={0: (-0.3, 0.4)})
    box = data.draw(boxes(first.n_inputs))
    found = model_bounds(model, box, max_boxes=9)
    y = model.predict(attack(box, np.random.default_rng(2)))
    assert found.low <= y.min() <= y.max() <= found.high
    limits = np.quantile(y, [0.1, 0.9]) if data.draw(st.booleans()) else (found.low, found.high)
    check = check_range(model, *limits, box, max_boxes=9)
    assert check.low <= y.min() <= y.max() <= check.high
    if y.min() < limits[0] or limits[1] < y.max():
        assert check.holds is not True
    for point in check.leaving:
        assert np.all((box[:, 0] <= point.point) & (point.point <= box[:, 1]))
        assert model.predict(point.point[None])[0] == point.value
        assert not limits[0] <= point.value <= limits[1]


def test_a_range_that_holds():
    model = model_of(single(0.0, -1.0, 0.0, 1.0), unit="m")
    check = check_range(model, -0.385, 0.385)  # 2 / sqrt(27) = 0.3849
    assert check.holds is True
    assert str(check).startswith("y cannot leave [-0.385, 0.385] m: it is proved to stay in [-0.38")
    assert check_range(model, -np.inf, 0.5).holds is True
    assert check_range(model, 0.0, 1.0, [[-0.9, -0.1]]).holds is True


def test_a_range_that_does_not_hold():
    model = model_of(single(0.0, 1.0, 0.0, 0.0), single(0.0, 0.0, 1.0, 0.0), edges={0: (0.5,)})
    check = check_range(model, -0.25, 2.0)
    assert check.holds is False
    assert [found.region for found in check.leaving] == ["x0 in (-inf, 0.5]"]
    assert str(check) == "y leaves [-0.25, 2]: it is -1 at x0 = -1 (x0 in (-inf, 0.5])"
    both = check_range(model, 0.0, 0.3)
    assert len(both.leaving) == 2
    assert "; 1 at x0 = 1 (x0 in (0.5, inf))" in str(both)


def test_a_range_that_cannot_be_decided():
    model = model_of(single(0.0, -1.0, 0.0, 1.0))
    check = check_range(model, -0.385, 0.3849002, max_boxes=2)
    assert check.holds is None
    assert not check.leaving
    assert "not decided with 2 boxes per region whether it stays in [-0.385, 0.3849]; it is proved to stay in [" in str(
        check
    )
    assert str(check).endswith("no point outside was found; open: everywhere")
    assert check_range(model, -0.385, 0.3849002).holds is True


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda n, m: network_bounds(n, [[0.0, 1.0]]), r"box has shape \(1, 2\); it must be \(2, 2\)"),
        (lambda n, m: network_bounds(n, "box"), "box = 'box': must hold low and high of each of the 2 inputs"),
        (lambda n, m: network_bounds(n, [[0, 1], [1, 0]]), r"box of input 1 = \[1.0, 0.0\]: must be two numbers"),
        (lambda n, m: network_bounds(n, [[np.nan, 1], [0, 1]]), r"box of input 0 = \[nan, 1.0\]"),
        (lambda n, m: network_bounds(n, [[np.inf, np.inf], [0, 1]]), r"box of input 0 = \[inf, inf\]"),
        (lambda n, m: network_bounds(n, tolerance=-0.1), "tolerance = -0.1: must be at least 0"),
        (lambda n, m: network_bounds(n, tolerance=np.nan), "tolerance = nan"),
        (lambda n, m: network_bounds(n, max_boxes=0), "max_boxes = 0: must be a whole number, at least 1"),
        (lambda n, m: model_bounds(m, [[1, 0], [0, 1]]), r"box of x0 = \[1.0, 0.0\]"),
        (lambda n, m: check_range(m, 1.0, 0.0), r"range \[1.0, 0.0\]: must be two numbers"),
        (lambda n, m: check_range(m, np.nan, 0.0), r"range \[nan, 0.0\]"),
        (lambda n, m: check_range(m, 0.0, 1.0, max_boxes=2.5), "max_boxes = 2.5"),
    ],
)
def test_bad_questions_are_named(call, message):
    network = Network((PRODUCT,), (0.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), 0.0, 1.0)
    with pytest.raises(InputError, match=message):
        call(network, model_of(network))


@pytest.mark.parametrize("number", [1, 3])
def test_networks_that_come_with_the_package_keep_their_range(number):
    model = shipped_models()[number]
    assert check_range(model, 0.0, max(network.y_high for network in model.networks)).holds is True


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 3])
def test_networks_that_come_with_the_package_are_bounded_closely(number):
    model = shipped_models()[number]
    found = model_bounds(model)
    rng = np.random.default_rng(0)
    for network, region in zip(model.networks, found.regions, strict=True):
        width = region.attained_high - region.attained_low
        assert region.converged
        assert region.high - region.low <= 1.03 * width + 1e-15
        box = np.column_stack([network.x_low, network.x_high])
        y = predict(network, np.vstack([attack(box, rng) for _ in range(50)]))
        assert region.low <= y.min() <= y.max() <= region.high


@settings(max_examples=60)
@given(st.data(), st.sampled_from([1e-320, 1e-310, 1e-300, 1e-200, 1e-154, 1e-100, 1e100, 1e154, 1e200, 1e300]))
def test_proofs_hold_at_any_scale_of_outputs(data, scale):
    """Down to subnormal numbers, where a product loses all of its digits."""
    drawn = data.draw(networks())
    y_mean = data.draw(st.sampled_from([0.0, drawn.y_mean * scale]))
    network = replace(drawn, y_mean=y_mean, y_scale=drawn.y_scale * scale, y_low=-UNBOUNDED, y_high=UNBOUNDED)
    box = data.draw(boxes(network.n_inputs, -1.0, 1.5))
    found = network_bounds(network, box, max_boxes=data.draw(st.sampled_from([1, 9])))
    y = predict(network, attack(box, np.random.default_rng(2)))
    assert found.low <= y.min()
    assert y.max() <= found.high
    for x in np.random.default_rng(3).uniform(box[:, 0], box[:, 1], size=(3, network.n_inputs)):
        exact = exact_output(network, np.clip(x, box[:, 0], box[:, 1]))
        assert found.low == -np.inf or Fraction(found.low) <= exact
        assert found.high == np.inf or exact <= Fraction(found.high)


@pytest.mark.parametrize("scale", [1e-319, 1e-305, 1e-200, 1e-160, 1.0, 1e160, 1e300])
def test_a_bowl_is_as_deep_at_any_scale(scale):
    """(x - 1/3)^2 - 1/9 on [-1, 1]: its least value lies inside, and is the ratio of a square and a coefficient."""
    bowl = replace(single(0.0, -2.0 / 3.0, 1.0, 0.0), y_scale=scale)
    found = network_bounds(bowl)
    least = exact_output(bowl, [Fraction(1, 3)])
    assert Fraction(found.low) <= least
    assert found.low == pytest.approx(-scale / 9.0, rel=0.02, abs=1e-315)


@pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e150, 1e300])
def test_proofs_hold_at_any_scale_of_inputs(scale):
    rng = np.random.default_rng(4)
    node = Node(DOUBLE, (0, 1), tuple(rng.normal(size=8)))
    ends = {"x_low": (-1.0 * scale, -0.5), "x_high": (1.5 * scale, 1.0), "x_scale": (scale, 1.0)}
    network = Network((node,), (0.1 * scale, 0.0), y_mean=0.0, y_scale=1.0, **ends)
    box = np.column_stack([network.x_low, network.x_high])
    found = network_bounds(network)
    y = predict(network, attack(box, rng))
    assert found.converged
    assert found.low <= y.min()
    assert y.max() <= found.high
