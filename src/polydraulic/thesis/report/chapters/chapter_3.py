"""Chapter 3, the modelling tool: database, the network of Fig 3-1, its growth, and the perceptron it is compared with."""

from typing import TYPE_CHECKING

import numpy as np

from polydraulic import units
from polydraulic.flow.database import PRESSURE_HIGH
from polydraulic.networks.model.model import Variable
from polydraulic.networks.model.nodes import KIND_NAMES, TERMS
from polydraulic.networks.plot import draw_history, draw_network
from polydraulic.tables import Table
from polydraulic.thesis.boom_models import SEED
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Chapter, Content, Figure, Ours
from polydraulic.thesis.report.figures.draw import canvas
from polydraulic.thesis.single_link import N_FULL_BOX, boom_study

if TYPE_CHECKING:
    import matplotlib.figure

NO_FIGURES = (
    "the thesis' figures are missing and its orifice areas are not printed; ours are calibrated to its statistics"
)


def content(lab: Lab) -> Content:
    """Numbers of section 3.1."""
    study = boom_study(lab)
    box = study.full_box
    x, p, q = (box.statistics[name] for name in box.statistics.names)
    fitted = box.estimator.network_
    sampled = f"of the {N_FULL_BOX} random points that the network was grown from"
    largest = units.from_si(study.machine.pumps.boom_flow, "in3/s")
    expected = float(np.sqrt(box.estimator.pse_))
    chosen = [step for step in box.estimator.history_ if step.accepted][-1]
    harder = f"K = {chosen.n_coefficients}; the fit is worse than printed because the map differs: {NO_FIGURES}"
    ours = {
        "database.x_mean_in": Ours(float(x.mean())),
        "database.x_spread": Ours(float(x.std())),
        "database.P_mean_psi": Ours(float(p.mean())),
        "database.P_spread": Ours(float(p.std())),
        "database.Qi_mean_in3_s": Ours(float(q.mean())),
        "database.Qi_spread": Ours(float(q.std())),
        "database.Qi_max_in3_s": Ours(float(q.max())),
        "database.Qo_max_boom_in3_s": Ours(float(units.from_si(study.grid["boom.q_out"].max(), "in3/s"))),
        "database.P_range_psi": Ours([0.0, units.from_si(PRESSURE_HIGH, "psi")]),
        "database.random_order_batch_size": Ours(
            N_FULL_BOX, "least squares over all rows at once: the order of the rows does not matter"
        ),
        "network_fig_3_1.N1.mean": Ours(fitted.x_mean[0], sampled),
        "network_fig_3_1.N1.sigma": Ours(fitted.x_scale[0], sampled),
        "network_fig_3_1.N2.mean": Ours(fitted.x_mean[1], sampled),
        "network_fig_3_1.N2.sigma": Ours(fitted.x_scale[1], sampled),
        "network_fig_3_1.U.mean": Ours(fitted.y_mean, sampled),
        "network_fig_3_1.U.sigma": Ours(fitted.y_scale, sampled),
        **_node_types(),
        "pse.KP": Ours(chosen.penalty),
        "pse.FSE": Ours(chosen.fse, harder),
        "pse.PSE": Ours(chosen.pse, harder),
        "pse.expected_abs_error_in3_s": Ours(expected, harder),
        "pse.expected_error_percent_of_max": Ours(100.0 * expected / largest, harder),
    }
    text = f"""<p>The boom circuit at random points (spool travel 0.188 to 0.564 in, input line pressure 0 to 4000 psi, no
    relief valve, seed {SEED}): statistics of {len(q):,} points, and one network over the whole box grown from {N_FULL_BOX:,}
    with the thesis' setting: complexity penalty multiplier 1, half the variance as prior error variance.</p>"""
    return Content(text, ours)


def _node_types() -> dict[str, Ours]:
    sizes = {KIND_NAMES[kind]: len(TERMS[kind]) for kind in TERMS}
    return {
        "network_fig_3_1.node_types.single": Ours(sizes["single"]),
        "network_fig_3_1.node_types.double": Ours(sizes["double"]),
        "network_fig_3_1.node_types.triple": Ours(sizes["triple"]),
    }


def network(lab: Lab) -> Figure:
    """Fig 3-1: the network over the whole active box."""
    box = boom_study(lab).full_box
    fitted = box.estimator.network_
    nodes = Table(
        {"mean": np.array([*fitted.x_mean, fitted.y_mean]), "scale": np.array([*fitted.x_scale, fitted.y_scale])}, {}
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=7.0, height=1.8)
        draw_network(axes[0, 0], fitted, box.inputs, Variable("q_in", "in3/s"))
        return figure

    see = "The thesis printed a single and a double that feed a triple, which also reads the travel; numbers count coefficients."
    return Figure("Network for boom input flow over the whole active box", see, {"": nodes}, draw)


def pse_curve(lab: Lab) -> Figure:
    """Fig 3-2: predicted squared error while the network grows."""
    history = boom_study(lab).full_box.estimator.history_
    columns = ("layer", "n_candidates", "n_coefficients", "fse", "penalty", "pse")
    steps = Table(
        {name: np.array([float(getattr(step, name)) for step in history]) for name in columns},
        dict.fromkeys(columns[3:], "(in3/s)^2"),
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=6.0, height=3.4)
        draw_history(axes[0, 0], history, "in3/s")
        return figure

    see = "The penalty rises with K, the fitting error falls; growth stops where their sum is smallest."
    return Figure("Predicted squared error while the network grows", see, {"": steps}, draw)


def perceptron(lab: Lab) -> Figure:
    """Fig 3-3: a three-layer perceptron, here the one that learns the boom's input flow."""
    model = boom_study(lab).perceptrons.q_in
    table = Table({"hidden units": np.array([float(len(model.networks[0].nodes) - 1)])}, {})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=7.0, height=4.2)
        draw_network(axes[0, 0], model.networks[0], model.inputs, model.output)
        return figure

    see = (
        "Every input reaches every hidden unit; a trained perceptron is a network of sigmoid nodes like any other here."
    )
    return Figure("Three-layer perceptron, trained on the boom's input flow", see, {"": table}, draw)


def neuron(lab: Lab) -> Figure:
    """Fig 3-4: what a unit does with the weighted sum of its inputs."""
    h = np.linspace(-6.0, 6.0, 241)
    steepness = (0.25, 0.5, 1.0)
    table = Table({"h": h, **{f"beta = {beta}": 1.0 / (1.0 + np.exp(-2.0 * beta * h)) for beta in steepness}}, {})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=5.0, height=3.0)
        for name in table.names[1:]:
            axes[0, 0].plot(h, table[name], label=name)
        axes[0, 0].set_xlabel("weighted sum of the inputs, h")
        axes[0, 0].set_ylabel("output g(h)")
        axes[0, 0].grid(alpha=0.3)
        axes[0, 0].legend(fontsize="small")
        return figure

    return Figure(
        "A unit of a perceptron", "It saturates on both sides: between, steepness is a gain.", {"": table}, draw
    )


CHAPTER = Chapter(
    3, "The modelling tool", content, {"3-1": network, "3-2": pse_curve, "3-3": perceptron, "3-4": neuron}
)
