"""What is proved of `float` C, held to the compiled code and to rational numbers."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from helpers.exact import exact_output
from helpers.exports import NAMES, drawn_nodes
from helpers.float_c import float_c, ways
from helpers.in_turn import in_turn
from polydraulic.errors import InputError
from polydraulic.export import bundle, export_c, to_c
from polydraulic.export.c import allowance
from polydraulic.export.c.allowance import allowance_lines, model_allowance
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Model, Network, Node, Variable
from polydraulic.networks.model.nodes import LINEAR, SIGMOID, SINGLE
from polydraulic.networks.model.partition import Split, region_of
from polydraulic.networks.model.table import UNBOUNDED


def model_of(*networks, partition=0, name="y"):
    n = networks[0].n_inputs
    return Model(tuple(Variable(f"x{i}") for i in range(n)), Variable(name), networks, partition)


def floats_inside(model, count, seed=0):
    """Float inputs in the domain, a third of them on its border."""
    rng = np.random.default_rng(seed)
    low, high = model.domain().T
    X = low + (high - low) * np.clip(rng.uniform(-0.25, 1.25, size=(count, len(low))), 0.0, 1.0)
    X = X.astype(np.float32)
    X = np.where(X.astype(float) > high, np.nextafter(X, np.float32(-np.inf)), X)
    X = np.where(X.astype(float) < low, np.nextafter(X, np.float32(np.inf)), X)
    return X[model.inside(X.astype(float))]


def exact(network, x):
    y = exact_output(network, x.tolist())
    return min(max(y, Fraction(network.y_low)), Fraction(network.y_high))


def largest(model, X, y):
    """Largest error against the package, and of the five worst rows against rational numbers."""
    X = X.astype(np.float64)
    off = np.abs(y - model.predict(X))
    region = region_of(model.partition, X)
    worst = np.argsort(off)[-5:]
    exactly = [abs(Fraction(y[i]) - exact(model.networks[region[i]], X[i])) for i in worst]
    return max(off.max(), *map(float, exactly))


coefficient = st.floats(-2.0, 2.0).filter(lambda v: v == 0.0 or abs(v) > 1e-9)


@st.composite
def scaled_networks(draw):
    """Networks over domains and with outputs of any size, and of any offset."""
    n_input = draw(st.integers(1, 3))
    nodes = drawn_nodes(draw, n_input, coefficient)
    powers = [
        draw(st.integers(-20, 20)) for _ in range(n_input + 1)
    ]  # of inputs and output, whose slopes fit into a float
    assume(max(powers[-1] - power for power in powers) < 28)
    scale = [draw(st.floats(0.5, 3.0)) * 10.0**power for power in powers[:-1]]
    mean = [s * draw(st.sampled_from([0.0, 0.3, -1.7, 1e3])) for s in scale]
    low, high = (tuple(m + side * s for m, s in zip(mean, scale, strict=True)) for side in (-1.3, 1.1))
    y_scale = draw(st.floats(0.5, 3.0)) * 10.0 ** powers[-1]
    bounds = draw(st.sampled_from([(-UNBOUNDED, UNBOUNDED), (-3.1 * y_scale, 2.7 * y_scale), (0.0, UNBOUNDED)]))
    y_mean = y_scale * draw(st.sampled_from([0.0, 1.1, -7.3]))
    return Network(nodes, tuple(mean), tuple(scale), low, high, y_mean, y_scale, *bounds)


@pytest.mark.slow
@settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    phases=[Phase.explicit, Phase.reuse, Phase.generate],  # to shrink what is compiled takes long
)
@given(st.lists(scaled_networks(), min_size=3, max_size=3))
def test_no_network_of_any_scale_leaves_its_allowance(tmp_path_factory, drawn):
    folder = tmp_path_factory.mktemp("c")
    models = [
        replace(model_of(network, name=f"y{k}"), inputs=tuple(Variable(f"x{k}_{i}") for i in range(network.n_inputs)))
        for k, network in enumerate(drawn)
    ]
    whole = bundle(models)
    rows = [floats_inside(model, 400, seed=k) for k, model in enumerate(models)]
    X = np.column_stack([part[: min(map(len, rows))] for part in rows])
    for way in ways():
        status, y = float_c(models, folder, way)(X)
        assert not np.any(status)
        for k, (model, place) in enumerate(zip(models, whole.places, strict=True)):
            found = model_allowance(model)
            own = X[:, list(place)]
            assert largest(model, own, y[:, k]) <= found.error
            assert found.low <= y[:, k].min()
            assert y[:, k].max() <= found.high


@pytest.mark.parametrize(("which", "way"), in_turn(NAMES, ways()))
def test_exported_models_keep_their_allowances_and_ranges(which, way, exported_models, tmp_path, record_property):
    models = exported_models[which]
    whole = bundle(models)
    X = whole.points(3000).astype(np.float32)
    status, y = float_c(models, tmp_path, way)(X)
    assert np.array_equal(status > 0, whole.outside(X.astype(float)) > 0.0)
    for k, (model, place) in enumerate(zip(models, whole.places, strict=True)):
        found = model_allowance(model)
        own = X[:, list(place)]
        inside = model.inside(own.astype(float))
        error = largest(model, own[inside], y[inside, k])
        record_property(model.output.name, f"{error / found.error if found.error else 0.0:.2f}")
        assert error <= found.error
        assert np.all((found.low <= y[:, k]) & (y[:, k] <= found.high))  # outside of the domain too
        assert found.error < 0.1 * np.ptp(model.predict(own.astype(float))) or which == "constant"


def shipped():
    """All networks of the package that a proof serves as a whole."""
    found = {model.networks: (name, model) for name, model in every_model() if len(model.networks) <= 26}
    return [
        pytest.param(model, id=name, marks=[pytest.mark.slow] if model.n_coefficients > 800 else [])
        for name, model in found.values()
    ]


def large():
    """Those of more regions than the budget of a proof does for."""
    found = {model.networks: (name, model) for name, model in every_model() if len(model.networks) > 26}
    return [pytest.param(model, id=name) for name, model in found.values()]


def every_model():
    kinds = {name: shipped_models(name, limited=name == "cascade") for name in ("cascade", "direct", "neural", "fine")}
    return [(f"{name}-{model.output.name}", model) for name, models in kinds.items() for model in models]


def kept_share(model, folder):
    """Largest error at random points as a share of the allowance, which it must not exceed."""
    function, found = float_c([model], folder), model_allowance(model)
    X = floats_inside(model, 20000)
    error = largest(model, X, function(X)[1][:, 0])
    print(f"{model.output.name}: {error:.3g} of {found.error:.3g}, {error / found.error:.3f} of it")
    assert error <= found.error
    return error / found.error


@pytest.mark.parametrize("model", shipped())
def test_networks_of_the_package_keep_their_allowances(model, tmp_path):
    assert kept_share(model, tmp_path) > 0.005


@pytest.mark.slow
@pytest.mark.parametrize("model", large())
def test_regions_of_large_networks_of_the_package_keep_theirs(model, tmp_path):
    """Some regions, each as a model of its own; where terms nearly cancel in a corner, points at random use next to nothing of it."""
    networks = [network for network in model.networks if network.nodes]
    shares = []
    for k, network in enumerate(networks[2 :: len(networks) // 5]):
        folder = tmp_path / str(k)
        folder.mkdir()
        shares.append(kept_share(replace(model, networks=(network,), partition=0), folder))
    assert len(shares) >= 5
    assert np.median(shares) > 0.03


def attacked(model, function, seed=0, rounds=30):
    """Inputs for which the error is largest, by a search around the worst ones found."""
    rng = np.random.default_rng(seed)
    low, high = model.domain().T
    X = floats_inside(model, 20000, seed)
    worst = 0.0
    width = 0.3
    for _ in range(rounds):
        off = np.abs(function(X)[1][:, 0] - model.predict(X.astype(np.float64)))
        worst = max(worst, off.max())
        best = X[np.argsort(off)[-40:]]
        step = width * (high - low) * rng.normal(size=(50, *best.shape)) * rng.integers(0, 2, size=(50, *best.shape))
        X = np.clip(best + step, low, high).reshape(-1, len(low)).astype(np.float32)
        X = np.vstack([best, X])
        X = X[model.inside(X.astype(np.float64))]
        width = max(0.7 * width, 1e-7)
    return worst


@pytest.mark.parametrize("number", [3, 5])
def test_a_search_for_the_worst_input_finds_none_beyond_the_allowance(number, tmp_path):
    model = shipped_models()[number]
    found = model_allowance(model)
    worst = attacked(model, float_c([model], tmp_path))
    print(f"{model.output.name}: {worst:.3g} of {found.error:.3g}")
    assert 0.1 * found.error < worst <= found.error


def test_half_of_an_allowance_does_not_do(tmp_path):
    constant = model_of(Network((), (0.0,), (1.0,), (-1.0,), (1.0,), 1.0 + 2.0**-24 * 0.99, 1.0))
    # A coefficient halfway between two floats, and a product that is rounded: two errors that may have one sign.
    between = 1.5 + 2.0**-24 * 0.999
    slope = model_of(
        Network((Node(SINGLE, (0,), (0.0, between, 0.0, 0.0)),), (0.0,), (1.0,), (1.0,), (1.33,), 0.0, 1.0)
    )
    for k, (model, least) in enumerate(((constant, 0.99), (slope, 0.6))):
        X = floats_inside(model, 20000)
        folder = tmp_path / str(k)
        folder.mkdir()
        error = largest(model, X, float_c([model], folder)(X)[1][:, 0])
        assert least * model_allowance(model).error < error <= model_allowance(model).error


def test_errors_that_cancel_are_not_taken_to_where_a_compiler_may_keep_one_of_them():
    # The sum of a product and nearly its negative: where the product may be fused on one side, its rounding does not cancel.
    errors = {}
    for one in (1.0, 1.25):
        nodes = Node(LINEAR, (0,), (1.1,)), Node(LINEAR, (1, 1), (one, -0.99999 * one))
        errors[one] = model_allowance(model_of(Network(nodes, (0.0,), (1.0,), (1.0,), (1.3,), 0.0, 1.0))).error
    assert errors[1.0] > 1.2 * errors[1.25]


def test_regions_and_domain_are_those_of_the_package_at_the_floats_beside_every_border(tmp_path):
    rng = np.random.default_rng(4)
    cuts = [*np.sort(rng.uniform(-1.0, 1.0, size=7)).tolist(), 1.25]
    partition = 0
    for k, cut in enumerate(cuts):
        partition = Split(0, cut, partition, k + 1)
    networks = [Network((), (0.0,), (1.0,), (-1.1,), (1.7,), float(k), 1.0) for k in range(len(cuts) + 1)]
    model = model_of(*networks, partition=partition)
    near = []
    for border in [*cuts, -1.1, 1.7]:
        middle = np.float32(border)
        near += [np.nextafter(middle, np.float32(-9)), middle, np.nextafter(middle, np.float32(9))]
    X = np.array(near, dtype=np.float32)[:, None]
    status, y = float_c([model], tmp_path)(X)
    assert np.array_equal(y[:, 0], model.predict(X.astype(np.float64)))
    assert np.array_equal(status == 0, model.inside(X.astype(np.float64)))
    assert 0 < np.sum(status) < len(X)
    nearest = region_of(Split(0, 0.1, 0, 1), np.float32([[0.1]]).astype(np.float64))
    assert nearest.tolist() == [1]  # a border rounded to the nearest float would answer for the other side


def test_a_domain_without_a_float_is_read_as_the_nearest_one(tmp_path):
    network = Network(
        (Node(SINGLE, (0,), (0.0, 1.0, 0.5, 0.0)),), (0.1,), (0.001,), (0.1,), (0.1,), 0.0, 1.0, -5.0, UNBOUNDED
    )
    model = model_of(network)
    status, y = float_c([model], tmp_path)(np.float32([[0.1], [0.2]]))
    found = model_allowance(model)
    assert status.tolist() == [0, 1]
    assert np.all(np.abs(y[:, 0] - model.predict(np.array([[0.1], [0.2]]))) <= found.error)
    assert found.error < 1e-5


def test_what_a_float_cannot_hold_is_refused():
    cube = Node(SINGLE, (0,), (0.0, 0.0, 0.0, 1e30))
    with pytest.raises(InputError, match="values of 'y' exceed what a float can hold"):
        model_allowance(model_of(Network((cube,), (0.0,), (1e-4,), (-1.0,), (1.0,), 0.0, 1.0, -1.0, 1.0)))
    with pytest.raises(InputError, match="does not fit into a float"):
        model_allowance(
            model_of(Network((Node(SINGLE, (0,), (0.0, 1e-42, 0.0, 1.0)),), (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0))
        )


def test_what_is_not_proved_is_said(exported_models, monkeypatch):
    monkeypatch.setattr(allowance, "model_allowance", lambda model: allowance.Allowance(np.inf, -np.inf, np.inf))
    (line,) = allowance_lines(exported_models["single"])
    assert line == "y: no proved allowance in float: 20000 boxes did not do"
    assert line in to_c(bundle(exported_models["single"]), real="float")[0]


def test_a_proof_takes_so_many_boxes_and_tells_of_which_output(exported_models, monkeypatch, tmp_path):
    spent = []

    def counted(*arguments):
        found = search(*arguments)
        spent.append(found[1])
        return found

    search = allowance.search
    monkeypatch.setattr(allowance, "search", counted)
    monkeypatch.setattr(allowance, "_CLOSE", 0.0)  # never close enough
    monkeypatch.setattr(allowance, "_BOXES", (20, 100))
    monkeypatch.setattr(allowance, "_ALL_BOXES", 150)
    (model,) = exported_models["regions"]
    found = allowance._allowance.__wrapped__(model.networks, model.partition)
    assert len(model.networks) + 20 < sum(spent) <= len(model.networks) + 150
    assert found.error > 0.0
    told = []
    export_c([model], tmp_path, real="float", progress=lambda *step: told.append(step))
    assert told == [(f"{model.output.name}: how far float can be off, 150 boxes at most", 0, 1)]


def test_numbers_that_are_shown_are_rounded_outward(exported_models):
    model = exported_models["regions"][0]
    found = model_allowance(model)
    (line,) = allowance_lines([model])
    words = line.split()
    low, high, error = (float(words[words.index(word) + 1]) for word in ("from", "to", "within"))
    assert low <= found.low
    assert high >= found.high
    assert found.error <= error <= 1.2 * found.error
    assert f" *   {line}" in to_c(bundle([model]), real="float")[0]
    assert "Proved" not in to_c(bundle([model]))[0]


@pytest.mark.parametrize("way", ways())
def test_the_logistic_function_of_the_code_is_within_its_bound(way, tmp_path):
    network = Network((Node(SIGMOID, (0,), (0.0, 1.0)),), (0.0,), (1.0,), (-100.0,), (100.0,), 0.0, 1.0)
    function = float_c([model_of(network)], tmp_path, way)
    bits = np.arange(np.float32(1e-6).view(np.int32), np.float32(100.0).view(np.int32), 331, dtype=np.int32)
    h = bits.view(np.float32)
    h = np.concatenate([h, -h])
    off = np.abs(function(h[:, None])[1][:, 0] - 1.0 / (1.0 + np.exp(-h.astype(np.float64)))).max()
    assert 1.0 * 2.0**-24 < off < 3.0 * 2.0**-24
