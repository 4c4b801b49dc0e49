import io

import numpy as np
from matplotlib.figure import Figure

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.networks import Variable
from polydraulic.networks.model.nodes import KIND_NAMES, LINEAR, RAMP, SIGMOID
from polydraulic.networks.model.table import Network, Node
from polydraulic.networks.plot import ROW, draw_history, draw_network, draw_regions, layers_of, node_rows

X = np.random.default_rng(5).uniform(-1.0, 1.0, size=(300, 2))


def test_a_drawing_shows_every_node():
    model = AbductiveRegressor().fit(X, np.exp(X[:, 0]) * X[:, 1])
    axis = Figure().subplots()
    draw_network(axis, model.network_, [Variable("p"), Variable("q")], Variable("flow"))
    texts = [text.get_text() for text in axis.texts]
    assert len(texts) == 2 + len(model.network_.nodes) + 1
    assert texts[0] == "N1\np"
    assert texts[-1] == "U\nflow"


def test_terms_that_were_left_out_of_a_node_are_not_counted():
    node = Node(LINEAR, (0, 1), (1.0, 0.0))
    network = Network((node,), (0.0,) * 2, (1.0,) * 2, (-1.0,) * 2, (1.0,) * 2, 0.0, 1.0, -9.0, 9.0)
    axis = Figure().subplots()
    draw_network(axis, network, [Variable("p"), Variable("q")], Variable("flow"))
    kind, number = axis.texts[2].get_text().split("\n")
    assert (kind, int(number)) == (KIND_NAMES[LINEAR], network.n_coefficients) == (KIND_NAMES[LINEAR], 1)


def test_a_node_stands_one_layer_behind_what_it_reads():
    chain = (Node(RAMP, (0,), (0.0, 1.0)), Node(RAMP, (1, 2), (0.0, 1.0, 1.0)), Node(LINEAR, (0, 3), (1.0, 1.0)))
    assert layers_of(Network(chain, (0.0,) * 2, (1.0,) * 2, (-1.0,) * 2, (1.0,) * 2, 0.0, 1.0, -9.0, 9.0)) == [
        0,
        0,
        1,
        2,
        3,
    ]


def test_boxes_of_many_nodes_and_few_inputs_keep_apart_in_a_figure_of_their_height():
    model = perceptron_of(15)
    figure = Figure(figsize=(7.0, ROW * (1 + node_rows(model))), layout="constrained")
    draw_network(figure.subplots(), model, [Variable("p", "Pa"), Variable("x", "m")], Variable("q", "m3/s"))
    figure.savefig(io.BytesIO(), format="png")
    boxes = [text.get_bbox_patch().get_window_extent() for text in figure.axes[0].texts]
    assert node_rows(model) == 15
    assert len(boxes) == 2 + 15 + 1 + 1
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def perceptron_of(n):
    """A network of two inputs, `n` nodes that read both, and one that reads these."""
    layer = [Node(SIGMOID, (0, 1), (0.1, 1.0, -1.0))] * n
    last = Node(SIGMOID, tuple(range(2, 2 + n)), (0.0, *n * (0.1,)))
    return Network((*layer, last), (0.0,) * 2, (1.0,) * 2, (-1.0,) * 2, (1.0,) * 2, 0.0, 1.0, -9.0, 9.0)


def test_the_history_shows_every_layer():
    model = AbductiveRegressor().fit(X, np.exp(X[:, 0]) * X[:, 1])
    axis = Figure().subplots()
    draw_history(axis, model.history_, "m")
    assert [len(line.get_xdata()) for line in axis.lines[:3]] == [len(model.history_) - 1] * 3


def test_borders_of_regions_are_drawn_inside_the_domain():
    model = RegionRegressor(AbductiveRegressor(max_layers=1), edges={0: [0.0], 1: [-0.5, 0.5]}).fit(X, X[:, 0])
    axis = Figure().subplots()
    draw_regions(axis, model.to_model([Variable("p", "Pa"), Variable("q")]))
    assert len(axis.lines) == 6
    assert axis.get_xlim() == (X[:, 0].min(), X[:, 0].max())
    assert {float(v) for line in axis.lines for v in line.get_ydata()} == {X[:, 1].min(), -0.5, 0.5, X[:, 1].max()}
    assert axis.get_xlabel() == "p [Pa]"


def test_names_are_drawn_as_they_are_not_as_formulas():
    names = [Variable(r"$\frac$", "$"), Variable("$q$")]
    model = (
        RegionRegressor(AbductiveRegressor(max_layers=1), edges={0: [0.0]})
        .fit(X, X[:, 0])
        .to_model(names, Variable("p_{"))
    )
    figure = Figure()
    first, second = figure.subplots(2)
    draw_regions(first, model)
    draw_network(second, model.networks[0], model.inputs, model.output)
    figure.draw_without_rendering()  # which reads formulas
    drawn = [text for text in (first.xaxis.label, first.yaxis.label, *second.texts) if text.get_parse_math()]
    shown = [text._preprocess_math(text.get_text()) for text in drawn]
    assert shown[:2] == [(r"$\frac$ [$]", False), ("$q$", False)]
    assert not any(formula for _, formula in shown)
