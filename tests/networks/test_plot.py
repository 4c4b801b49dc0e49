import numpy as np
from matplotlib.figure import Figure

from polydraulic.networks import AbductiveRegressor, Variable
from polydraulic.networks.plot import draw_history, draw_network

X = np.random.default_rng(5).uniform(-1.0, 1.0, size=(300, 2))


def test_a_drawing_shows_every_node():
    model = AbductiveRegressor().fit(X, np.exp(X[:, 0]) * X[:, 1])
    axis = Figure().subplots()
    draw_network(axis, model.network_, [Variable("p"), Variable("q")], Variable("flow"))
    texts = [text.get_text() for text in axis.texts]
    assert len(texts) == 2 + len(model.network_.nodes) + 1
    assert texts[0] == "N1\np"
    assert texts[-1] == "U\nflow"


def test_the_history_shows_every_layer():
    model = AbductiveRegressor().fit(X, np.exp(X[:, 0]) * X[:, 1])
    axis = Figure().subplots()
    draw_history(axis, model.history_, "m")
    assert [len(line.get_xdata()) for line in axis.lines[:3]] == [len(model.history_) - 1] * 3
