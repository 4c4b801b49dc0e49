"""Formulas of models: the numbers of the package, bit for bit where that is promised."""

import builtins
import re
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.exports import networks
from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.errors import InputError
from polydraulic.export.formula import to_latex, to_python, to_sympy, to_text
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Model, Network, Node, PerceptronRegressor, Variable
from polydraulic.networks.model.nodes import KIND_NAMES

RNG = np.random.default_rng(9)
X = RNG.uniform(-1.0, 1.0, size=(300, 3))
Y = np.exp(X[:, 0]) * np.cos(3.0 * X[:, 1]) + np.abs(X[:, 2])
NAMED = ([Variable("x_in", "m"), Variable("p", "m3/s"), Variable("50% {load}")], Variable("boom.q_out", "Pa"))


@cache
def model_of(which: str) -> Model:
    two_layers = AbductiveRegressor(max_layers=2, refine=False, output_bounds=None)
    if which == "single network":
        return two_layers.fit(X, Y).to_model(*NAMED)
    if which == "with a linear node":
        return AbductiveRegressor(kinds=("single", "linear"), refine=False).fit(X, Y).to_model()
    if which == "regions":
        edges = {2: [0.0], 0: [-0.3, 0.4]}
        base = AbductiveRegressor(max_layers=2, refine=False, output_bounds=(0.0, 2.0))
        return RegionRegressor(base, edges=edges).fit(X, Y).to_model(*NAMED)
    if which == "raw units":
        raw = X * [1.0, 1e-6, 300.0] + [1e5, 0.0, 0.0]
        return two_layers.fit(raw, 1e6 * Y).to_model()
    if which == "one input":
        return two_layers.fit(X[:, :1], X[:, 0] ** 2).to_model()
    if which == "perceptron":
        return PerceptronRegressor(hidden_units=3, max_iter=20, n_starts=1).fit(X, Y).to_model(*NAMED)
    if which == "ramps":
        nodes = Node(5, (0, 1), (-0.2, 0.6, 0.3)), Node(5, (2,), (-0.1, -0.8)), Node(2, (3, 4, 2), (0.1,) * 14)
        return Model(
            tuple(NAMED[0]),
            NAMED[1],
            (Network(nodes, (0.1,) * 3, (0.5,) * 3, (-1.0,) * 3, (1.0,) * 3, 0.5, 3.0, -9.0, 9.0),),
        )
    if which == "constant":
        return two_layers.fit(X, np.full(len(X), -2.5)).to_model()
    return shipped_models()[3]


MODELS = (
    "single network",
    "with a linear node",
    "regions",
    "raw units",
    "one input",
    "perceptron",
    "ramps",
    "constant",
    "shipped",
)


def points(model: Model, n: int = 300) -> np.ndarray:
    """Random points inside and outside the domain, its corners, points on every edge and just above it."""
    rng = np.random.default_rng(1)
    low, high = model.domain().T
    width = np.where(high > low, high - low, 1.0)
    found = [low - 0.2 * width + 1.4 * width * rng.uniform(size=(n, len(low)))]
    found.append(np.array(np.meshgrid(*model.domain())).reshape(len(low), -1).T)
    for k in range(len(model.networks)):
        for axis, border in enumerate(model.region_boxes()[k]):
            for cut in border[np.isfinite(border)]:
                on, above = found[0][:10].copy(), found[0][:10].copy()
                on[:, axis], above[:, axis] = cut, np.nextafter(cut, np.inf)
                found += [on, above]
    return np.vstack(found)


def defined(model: Model, name: str = "f"):
    place = {}
    exec(to_python(model, name), place)
    return place[name]


def inside(model: Model, rows: np.ndarray) -> np.ndarray:
    """Rows in the domain of the network that answers for them."""
    good = np.zeros(len(rows), dtype=bool)
    for k, network in enumerate(model.networks):
        low, high = model.region_boxes()[k].T
        here = np.all((rows > low) & (rows <= high), axis=1)
        good |= here & np.all((rows >= network.x_low) & (rows <= network.x_high), axis=1)
    return rows[good]


@pytest.mark.parametrize("which", MODELS)
def test_python_source_gives_the_bits_of_predict(which):
    model = model_of(which)
    function = defined(model)
    rows = points(model)
    assert np.array_equal([function(*row) for row in rows.tolist()], model.predict(rows))
    assert function(rows[0]) == function(*rows[0]) == function(list(rows[0])) == model.predict(rows[:1])[0]


def test_python_source_takes_whole_numbers_and_refuses_a_wrong_count():
    function = defined(model_of("regions"))
    assert function(1, 0, 0) == function(1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="unpack"):
        function(1.0, 2.0)


@given(networks(), st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3))
def test_any_network_as_python_gives_the_bits_of_predict(network, values):
    names = tuple(Variable(f"x{i}") for i in range(network.n_inputs))
    model = Model(names, Variable("y"), (network,))
    row = values[: network.n_inputs]
    assert defined(model)(*row) == model.predict(np.array([row]))[0]


@pytest.mark.parametrize("name", ["", "2q", "a b", "class"])
def test_a_name_that_cannot_name_a_function_is_an_error(name):
    with pytest.raises(InputError, match="Python identifier"):
        to_python(model_of("constant"), name)


def test_doc_of_the_python_source_tells_names_units_and_domain_whatever_they_hold():
    model = model_of("one input")
    odd = Model((Variable('a"""\n\\', "m"),), Variable("é\n#", "Pa"), model.networks, model.partition)
    function = defined(odd)
    assert 'x0: a""" \\ [m], domain -' in function.__doc__
    assert "é # [Pa] from" in function.__doc__
    assert function(0.25) == model.predict(np.array([[0.25]]))[0]


def lambdified(model: Model, **options):
    sympy = pytest.importorskip("sympy")
    symbols = [sympy.Symbol(variable.name) for variable in model.inputs]
    function = sympy.lambdify(symbols, to_sympy(model, **options), "numpy", cse=True)
    return lambda rows: np.broadcast_to(function(*rows.T), len(rows))


def assert_close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("which", MODELS)
def test_clamped_sympy_expression_equals_predict_everywhere(which):
    model = model_of(which)
    rows = points(model)
    assert_close(lambdified(model, clamp=True)(rows), model.predict(rows))


@pytest.mark.parametrize("which", [which for which in MODELS if which not in ("regions", "shipped")])
def test_sympy_expression_equals_predict_inside_and_goes_on_outside(which):
    model = model_of(which)
    rows = points(model)
    found, good = lambdified(model), inside(model, rows)
    assert len(good) >= 10
    assert_close(found(good), model.predict(good))
    if which not in ("constant", "one input"):
        assert not np.allclose(found(rows), model.predict(rows))


def test_regions_are_a_piecewise_that_covers_everything():
    sympy = pytest.importorskip("sympy")
    model = model_of("regions")
    expression = to_sympy(model)
    assert isinstance(expression, sympy.Piecewise)
    assert len(expression.args) == len(model.networks)
    assert expression.args[-1][1] == sympy.true
    assert {symbol.name for symbol in expression.free_symbols} == {variable.name for variable in model.inputs}


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize("which", ["one input", "constant", "two inputs"])
def test_expanded_expression_is_one_polynomial_with_the_same_values(which, clamp):
    sympy = pytest.importorskip("sympy")
    if which == "two inputs":
        learner = AbductiveRegressor(max_layers=2, refine=False, output_bounds=None)
        model = learner.fit(X[:, :2], np.sin(X[:, 0] * X[:, 1])).to_model()
    else:
        model = model_of(which)
    rows = points(model)
    rows = rows if clamp else inside(model, rows)
    assert_close(lambdified(model, clamp=clamp, expanded=True)(rows), model.predict(rows))
    if not clamp:
        polynomial = sympy.Poly(to_sympy(model, expanded=True), *sympy.symbols([v.name for v in model.inputs]))
        assert len(polynomial.terms()) == len(sympy.Add.make_args(to_sympy(model, expanded=True)))


def test_an_expansion_that_is_too_long_or_loses_digits_is_refused():
    pytest.importorskip("sympy")
    with pytest.raises(InputError, match="terms of the expanded polynomial cancel"):
        to_sympy(model_of("raw units"), expanded=True)
    cubes = tuple(Node(2, slots, (0.0,) * 10 + (1.0, 1.0, 1.0, 1.0)) for slots in ((0, 1, 2), (0, 1, 3), (1, 2, 4)))
    zeros, ones = (0.0,) * 3, (1.0,) * 3
    deep = Network(cubes, zeros, ones, zeros, ones, 0.0, 1.0)
    model = Model(tuple(map(Variable, "abc")), Variable("y"), (deep,))
    with pytest.raises(InputError, match="degree 27 in 3 inputs"):
        to_sympy(model, expanded=True)
    assert to_sympy(model, expanded=False) != 0


def test_sympy_needs_the_extra_and_different_names(monkeypatch):
    model = model_of("single network")
    same = Model((Variable("a"), Variable("b"), Variable("a")), model.output, model.networks, model.partition)
    real = builtins.__import__

    def without(name, *args, **options):
        if name.startswith("sympy"):
            raise ImportError(name)
        return real(name, *args, **options)

    with monkeypatch.context() as patch:
        patch.setattr(builtins, "__import__", without)
        with pytest.raises(InputError, match=r"pip install polydraulic\[export\]"):
            to_sympy(model)
    pytest.importorskip("sympy")
    with pytest.raises(InputError, match="symbols need different names"):
        to_sympy(same)


@pytest.mark.parametrize("which", MODELS)
def test_text_lists_every_node_name_unit_and_domain(which):
    model = model_of(which)
    text = to_text(model)
    blocks = text.split("\n\n")[1:]
    assert len(blocks) == len(model.networks)
    for network, block in zip(model.networks, blocks, strict=True):
        for number, node in enumerate(network.nodes, start=1):
            assert re.search(rf"^z{number} = .*\({KIND_NAMES[node.kind]}\)$", block, re.MULTILINE)
        assert f"z{len(network.nodes) + 1} =" not in block
        for variable, low, high in zip(model.inputs, network.x_low, network.x_high, strict=True):
            assert f"domain of {variable.name}: {low:.6g} to {high:.6g} {variable.unit}".rstrip() in block.splitlines()
        assert "y is clamped" in block or network.y_high > 1e308
    assert str(model.output) in text
    assert all(str(variable) in text for variable in model.inputs)


def test_text_names_the_regions():
    text = to_text(model_of("regions"))
    assert "where x_in <= -0.3 and 50% {load} <= 0:" in text
    assert "where -0.3 < x_in <= 0.4 and 50% {load} > 0:" in text
    assert "y is clamped to 0 to 2 Pa" in text


def assert_structured(latex: str) -> None:
    bare = re.sub(r"\\[\\{}%&#_$]", "", latex)
    depth = np.cumsum([(c == "{") - (c == "}") for c in bare])
    assert depth.min() >= 0
    assert depth[-1] == 0
    assert not re.search(r"[%#$]", bare)
    open_environments = []
    for what, name in re.findall(r"\\(begin|end)\{(\w+)\}", latex):
        if what == "begin":
            open_environments.append(name)
        else:
            assert open_environments.pop() == name
    assert not open_environments
    for block in re.findall(r"\\begin\{aligned\}(.*?)\\end\{aligned\}", latex, re.DOTALL):
        for line in block.split(" \\\\\n"):
            assert line.replace("\\&", "").count("&") == 3
    assert "__" not in bare
    assert not re.search(r"\de[+-]?\d", latex)


@pytest.mark.parametrize("which", MODELS)
def test_latex_is_balanced_and_holds_every_variable_and_node(which):
    model = model_of(which)
    latex = to_latex(model)
    assert_structured(latex)
    assert latex.count("\\begin{aligned}") == len(model.networks)
    assert ("\\begin{cases}" in latex) == (len(model.networks) > 1)
    assert len(re.findall(r"^z_\{\d+\} &=", latex, re.MULTILINE)) == sum(len(n.nodes) for n in model.networks)
    assert len(re.findall(r" \\in \[", latex)) == len(model.networks) * len(model.inputs)


def test_latex_names_units_numbers_and_regions():
    latex = to_latex(model_of("regions"), digits=3)
    for part in (r"x_{\mathrm{in}}", "p", r"\text{50\% \{load\}}", r"\mathrm{boom}_{\mathrm{q\_out}}"):
        assert part in latex
    for part in (r"\text{m3/s}", r"\text{Pa}", r"\hat{x}_{\mathrm{in}} &= \frac{x_{\mathrm{in}}", r"\min(\max("):
        assert part in latex
    assert r"-0.3 < x_{\mathrm{in}} \le 0.4, 0 < \text{50\% \{load\}}" in latex
    assert not re.search(r"[1-9]\.\d{3}", latex)
    assert re.search(r"\\times 10\^\{-7\}", to_latex(model_of("raw units")))  # the second input is in millionths
    with pytest.raises(InputError, match="digits = 0"):
        to_latex(model_of("regions"), digits=0)


def test_latex_tells_names_apart_that_would_look_the_same():
    model = model_of("single network")
    alike = Model((Variable("x1"), Variable("x_1"), Variable("z\\")), Variable("y"), model.networks, model.partition)
    latex = to_latex(alike)
    assert_structured(latex)
    assert r"\text{x1}" in latex
    assert r"\text{x\_1}" in latex
    assert r"\text{z\textbackslash{}}" in latex
    taken = Model((Variable("z1"), Variable("w"), Variable("c")), Variable("y"), model.networks, model.partition)
    assert "v_{1} &=" in to_latex(taken)
