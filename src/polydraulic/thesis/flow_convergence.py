"""Flow models with volumes against the one without: what a volume does to the pump pressure, and how fast it fades.

`stiff` approaches `exact` in proportion to its volumes. `tlm` does so when its delay shrinks with them; at a fixed volume,
the delay alone is of second order. The time step stays as it is: all models see lines that move in the same way.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic.flow.dispatch import build_flow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import Scenario
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import compare
from polydraulic.tables import Table
from polydraulic.thesis.excavator import pump_of

LITRE = 1e-3  # m3
BETWEEN = 0.2  # passage between the valves, as a share of a pump's pipe
VOLUMES = (10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01)  # litres
SUBSTEPS = (1, 2, 4, 8, 16, 32)  # of the transmission lines, with 2 litres at the first
_FINE = 128
_FLOW = "swing.q_in"


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


def flow_convergence(machine: LayoutMachine, scenario: Scenario, *, dt: float = 5e-3) -> Convergence:
    """Run a scenario with ever smaller volumes and delays.

    Parameters
    ----------
    machine : LayoutMachine
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
        return compare(reference, table)[_FLOW].rms / pump_of(machine, "series").flow

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
