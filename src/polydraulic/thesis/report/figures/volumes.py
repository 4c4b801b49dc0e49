"""Figure of the flow models with volumes: what a volume does to the pump pressure, and how fast it fades."""

from typing import TYPE_CHECKING

from polydraulic.parameters.scenario import load_scenario
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.flow_convergence import Convergence, Curve, flow_convergence
from polydraulic.thesis.printed_units import in_field_units
from polydraulic.thesis.report.catalog import Figure
from polydraulic.thesis.report.figures.draw import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_PRESSURE = "series.p_pump"


def volumes(lab: Lab) -> Figure:
    """Pump pressure as the valves of the pulse open, and errors over volume and delay."""
    lab.say("volumes between pump and valves")
    return convergence_figure(flow_convergence(lab.machine, load_scenario("pulse")), window=(0.0, 0.6))


def convergence_figure(found: Convergence, *, window: tuple[float, float]) -> Figure:
    """Figure of the study: pump pressure in a window of time in s, and errors over volume and delay."""
    time = found.runs["exact"]["time"]
    inside = (time >= window[0]) & (time <= window[1])
    traces = {"time": time[inside]}
    for label, table in found.runs.items():
        traces[label] = in_field_units(table, _PRESSURE)[0][inside]
    data = {
        "pressure": Table(traces, {"time": "s", **dict.fromkeys(found.runs, "psi")}),
        "volume": Table({"volume": found.stiff.scale, "error": found.stiff.error}, {"volume": "l"}),
        "volume and delay": Table({"volume": found.lines.scale, "error": found.lines.error}, {"volume": "l"}),
        "delay": Table({"delay": found.delay.scale, "error": found.delay.error}, {"delay": "ms"}),
    }

    def draw() -> "Drawing":
        figure, axes = canvas(2, 2, width=9.6, height=3.2)
        labels = list(found.runs)
        _traces(axes[0, 0], data["pressure"], [labels[0], *labels[1:3]], "pump pressure, stiff")
        _traces(axes[0, 1], data["pressure"], [labels[0], *labels[3:]], "pump pressure, transmission lines")
        _errors(axes[1, 0], {"stiff": found.stiff, "tlm, delay in proportion": found.lines}, "volume of a pipe [l]", 1)
        _errors(axes[1, 1], {"tlm, 1 l, alpha 0": found.delay}, "delay [ms]", 2)
        axes[1, 1].set_xticks(found.delay.scale, [f"{delay:.3g}" for delay in found.delay.scale], minor=False)
        axes[1, 1].tick_params(axis="x", which="minor", labelbottom=False)
        axes[1, 0].set_title("swing flow minus exact", fontsize="medium")
        axes[1, 1].set_title("swing flow minus that with very short delays", fontsize="medium")
        return figure

    return Figure(
        "Volumes between pump and valves",
        "A volume delays the pump pressure, and transmission lines (tlm) ring. Both effects vanish as the volume (first order) and the delay (second order) go to zero.",
        data,
        draw,
    )


def _traces(axis: "Axes", table: Table, labels: list[str], title: str) -> None:
    looks = [("#9ec5e8", 3.5), ("C3", 1.2), ("C1", 1.2)]
    for label, (color, width) in zip(labels, looks, strict=True):
        axis.plot(table["time"], table[label], color=color, linewidth=width, label=label)
    axis.set_title(title, fontsize="medium")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("pump pressure [psi]")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small")


def _errors(axis: "Axes", curves: dict[str, Curve], label: str, order: int) -> None:
    for (name, curve), marker in zip(curves.items(), "os", strict=False):
        axis.loglog(curve.scale, curve.error, marker, label=f"{name}: order {curve.order:.2f}")
        guide = curve.error[-1] * (curve.scale / curve.scale[-1]) ** order
        axis.loglog(curve.scale, guide, "--", color="0.6", linewidth=1.0)
    axis.set_xlabel(label)
    axis.set_ylabel("rms error / pump flow [1]")
    axis.grid(alpha=0.3, which="both")
    axis.legend(fontsize="small", title=f"dashed: order {order}", title_fontsize="small")
