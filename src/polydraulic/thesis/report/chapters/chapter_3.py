"""Chapter 3, the modelling tool: database, the network of Fig 3-1, its growth, and the perceptron it is compared with."""

from typing import TYPE_CHECKING

import numpy as np

from polydraulic import units
from polydraulic.networks.model.model import Variable
from polydraulic.networks.model.nodes import KIND_NAMES, TERMS
from polydraulic.networks.plot import ROW, draw_history, draw_network, node_rows
from polydraulic.tables import Table
from polydraulic.thesis.boom_models import SEED
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import PRESSURE_HIGH, pump_of
from polydraulic.thesis.report.catalog import Chapter, Computed, Content, Figure, Paragraph
from polydraulic.thesis.report.figures.draw import canvas
from polydraulic.thesis.single_link import N_FULL_BOX, boom_study

if TYPE_CHECKING:
    import matplotlib.figure

NO_FIGURES = "the thesis does not print its orifice areas; those used here are calibrated to its printed statistics"


def content(lab: Lab) -> Content:
    """Numbers of section 3.1."""
    study = boom_study(lab)
    box = study.full_box
    x, p, q = (box.statistics[name] for name in box.statistics.names)
    fitted = box.estimator.network_
    sampled = f"of the {N_FULL_BOX} random points from which the network was grown"
    largest = units.from_si(pump_of(study.machine, "boom").flow, "in3/s")
    expected = float(np.sqrt(box.estimator.pse_))
    chosen = [step for step in box.estimator.history_ if step.accepted][-1]
    harder = f"K = {chosen.n_coefficients} coefficients; larger than printed because the map differs: {NO_FIGURES}"
    computed = {
        "database.x_mean_in": Computed(float(x.mean())),
        "database.x_spread": Computed(float(x.std())),
        "database.P_mean_psi": Computed(float(p.mean())),
        "database.P_spread": Computed(float(p.std())),
        "database.Qi_mean_in3_s": Computed(float(q.mean())),
        "database.Qi_spread": Computed(float(q.std())),
        "database.Qi_max_in3_s": Computed(float(q.max())),
        "database.Qo_max_boom_in3_s": Computed(float(units.from_si(study.grid["boom.q_out"].max(), "in3/s"))),
        "database.P_range_psi": Computed([0.0, units.from_si(PRESSURE_HIGH, "psi")]),
        "database.random_order_batch_size": Computed(
            N_FULL_BOX, "all rows are used in one least-squares fit, so that their order does not matter"
        ),
        "network_fig_3_1.N1.mean": Computed(fitted.x_mean[0], sampled),
        "network_fig_3_1.N1.sigma": Computed(fitted.x_scale[0], sampled),
        "network_fig_3_1.N2.mean": Computed(fitted.x_mean[1], sampled),
        "network_fig_3_1.N2.sigma": Computed(fitted.x_scale[1], sampled),
        "network_fig_3_1.U.mean": Computed(fitted.y_mean, sampled),
        "network_fig_3_1.U.sigma": Computed(fitted.y_scale, sampled),
        **_node_types(),
        "pse.KP": Computed(chosen.penalty),
        "pse.FSE": Computed(chosen.fse, harder),
        "pse.PSE": Computed(chosen.pse, harder),
        "pse.expected_abs_error_in3_s": Computed(expected, harder),
        "pse.expected_error_percent_of_max": Computed(100.0 * expected / largest, harder),
    }
    return Content(_text(len(q)), computed)


def _text(n_points: int) -> list[Paragraph]:
    return [
        Paragraph(
            f"The boom circuit is solved exactly at random points: spool travel 0.188 to 0.564 in, input line pressure 0 to "
            f"4000 psi, no relief valve. The statistics are those of {n_points:,} points. One polynomial network of the input flow "
            f"over the whole range is grown from {N_FULL_BOX:,} points (seed {SEED}) in the thesis' setting: a network stops growing "
            "where the predicted squared error (PSE), the sum of fitting error and complexity penalty, is smallest; the penalty "
            "multiplier is 1 and the prior error variance is half the variance of the output.",
            "Data and one network.",
        ),
        Paragraph(
            "The printed mean, spread and largest value of the input flow are reproduced, because the orifice areas are calibrated to "
            "them. The error of the network is not: it depends on the shape of the map, for which the thesis gives no data.",
            "What agrees and what does not.",
        ),
    ]


def _node_types() -> dict[str, Computed]:
    sizes = {KIND_NAMES[kind]: len(TERMS[kind]) for kind in TERMS}
    return {
        "network_fig_3_1.node_types.single": Computed(sizes["single"]),
        "network_fig_3_1.node_types.double": Computed(sizes["double"]),
        "network_fig_3_1.node_types.triple": Computed(sizes["triple"]),
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

    see = "Each box is a node; its number is the number of coefficients. The thesis printed a single (one input) and a double (two inputs) that feed a triple, which also reads the spool travel."
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

    see = "The penalty rises with the number of coefficients K, the fitting error falls; growth stops where their sum is smallest."
    return Figure("Predicted squared error while the network grows", see, {"": steps}, draw)


def perceptron(lab: Lab) -> Figure:
    """Fig 3-3: a three-layer perceptron, here the one that learns the boom's input flow."""
    model = boom_study(lab).perceptrons.q_in
    table = Table({"hidden units": np.array([float(len(model.networks[0].nodes) - 1)])}, {})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=7.0, height=ROW * (1 + node_rows(model.networks[0])))
        draw_network(axes[0, 0], model.networks[0], model.inputs, model.output)
        return figure

    see = "Every input is connected to every hidden unit."
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
        "A unit of a perceptron",
        "The output saturates on both sides; in between, the steepness beta acts as a gain.",
        {"": table},
        draw,
    )


CHAPTER = Chapter(
    3,
    "The modelling tool",
    "The database of the boom circuit, one polynomial network over all of it, its growth, and a perceptron.",
    content,
    {"3-1": network, "3-2": pse_curve, "3-3": perceptron, "3-4": neuron},
)
