"""Flow models with volumes against the one without: what a volume does to the pump pressure, and how fast it fades.

`stiff` approaches `exact` in proportion to its volumes. `tlm` does so when its delay shrinks with them; at a fixed volume,
the delay alone is of second order. The time step stays as it is: all models see lines that move in the same way.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from polydraulic.flow import build_flow
from polydraulic.parameters import Machine, Scenario
from polydraulic.simulation import compare, simulate
from polydraulic.simulation.trajectory import in_field_units
from polydraulic.studies.catalog import Figure
from polydraulic.studies.draw import canvas
from polydraulic.tables import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

LITRE = 1e-3  # m3
BETWEEN = 0.2  # passage between the valves, as a share of a pump's pipe
VOLUMES = (10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01)  # litres
SUBSTEPS = (1, 2, 4, 8, 16, 32)  # of the transmission lines, with 2 litres at the first
_FINE = 128
_PRESSURE, _FLOW = "series.p_pump", "swing.q_in"


class Curve(NamedTuple):
    """Errors that fall with a scale, and the order at which they do."""

    scale: np.ndarray
    error: np.ndarray  # rms as a share of the pump's flow

    @property
    def order(self) -> float:
        """Slope of the errors over the scale, both as logarithms."""
        return float(np.polyfit(np.log(self.scale), np.log(self.error), 1)[0])


class Convergence(NamedTuple):
    """What the study found.

    Attributes
    ----------
    runs : dict from label to trajectory
        Those of the upper panels.
    stiff : Curve
        Error against exact over the pump pipe's volume in litres.
    lines : Curve
        The same of transmission lines whose delay shrinks with the volume.
    delay : Curve
        Error of transmission lines of one litre over their delay in ms, against very short ones.
    """

    runs: dict[str, Table]
    stiff: Curve
    lines: Curve
    delay: Curve


def flow_convergence(machine: Machine, scenario: Scenario, *, dt: float = 5e-3) -> Convergence:
    """Run a scenario with ever smaller volumes and delays.

    Parameters
    ----------
    machine : Machine
    scenario : Scenario
        Must move swing and stick.
    dt : float, s
    """

    def run(name: str, litres: float, **options: Any) -> Table:
        volume = litres * LITRE
        model = build_flow(name, machine, volume=volume, volume_between=BETWEEN * volume, **options)
        return simulate(machine, model, scenario, dt=dt)

    exact = simulate(machine, "exact", scenario, dt=dt)

    def error(reference: Table, table: Table) -> float:
        return compare(reference, table)[_FLOW].rms / machine.pumps.series_flow

    def lines(n: int, litres: float) -> Table:
        return run("tlm", litres, substeps=n)

    stiff = {v: run("stiff", v) for v in VOLUMES}
    shrinking = np.array([2.0 / n for n in SUBSTEPS])
    fine = run("tlm", 1.0, substeps=_FINE, alpha=0.0)
    return Convergence(
        runs={
            "exact": exact,
            "stiff, 10 l": stiff[10.0],
            "stiff, 1 l": stiff[1.0],
            f"tlm, 1 l, delay {1e3 * dt:g} ms, alpha 0": run("tlm", 1.0, substeps=1, alpha=0.0),
            f"tlm, 1 l, delay {250.0 * dt:g} ms": run("tlm", 1.0, substeps=4),
        },
        stiff=Curve(np.array(VOLUMES), np.array([error(exact, table) for table in stiff.values()])),
        lines=Curve(shrinking, np.array([error(exact, lines(n, v)) for n, v in zip(SUBSTEPS, shrinking, strict=True)])),
        delay=Curve(
            1e3 * dt / np.array(SUBSTEPS[:5]),
            np.array([error(fine, run("tlm", 1.0, substeps=n, alpha=0.0)) for n in SUBSTEPS[:5]]),
        ),
    )


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
        _errors(axes[1, 0], {"stiff": found.stiff, "tlm, delay shrinks alike": found.lines}, "volume of a pipe [l]", 1)
        _errors(axes[1, 1], {"tlm, 1 l, alpha 0": found.delay}, "delay [ms]", 2)
        axes[1, 1].set_xticks(found.delay.scale, [f"{delay:.3g}" for delay in found.delay.scale], minor=False)
        axes[1, 1].tick_params(axis="x", which="minor", labelbottom=False)
        axes[1, 0].set_title("swing flow less exact", fontsize="medium")
        axes[1, 1].set_title("swing flow less that of very short delays", fontsize="medium")
        return figure

    return Figure(
        "5-C1",
        "Volumes between pump and valves",
        "a volume delays the pump pressure and lines ring, and both fade: first order in the volume, second in the delay",
        data,
        draw,
    )


def _traces(axis: "Axes", table: Table, labels: list[str], title: str) -> None:
    looks = [("#9ec5e8", 3.5), ("C3", 1.2), ("C1", 1.2)]
    for label, (color, width) in zip(labels, looks, strict=True):
        axis.plot(table["time"], table[label], color=color, linewidth=width, label=label)
    axis.set_title(title, fontsize="medium")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("[psi]")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small")


def _errors(axis: "Axes", curves: dict[str, Curve], label: str, order: int) -> None:
    for (name, curve), marker in zip(curves.items(), "os", strict=False):
        axis.loglog(curve.scale, curve.error, marker, label=f"{name}: order {curve.order:.2f}")
        guide = curve.error[-1] * (curve.scale / curve.scale[-1]) ** order
        axis.loglog(curve.scale, guide, "--", color="0.6", linewidth=1.0)
    axis.set_xlabel(label)
    axis.set_ylabel("rms error / pump flow")
    axis.grid(alpha=0.3, which="both")
    axis.legend(fontsize="small", title=f"dashed: order {order}", title_fontsize="small")
