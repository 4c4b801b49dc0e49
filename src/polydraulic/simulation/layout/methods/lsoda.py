"""Reference solution of a machine of any layout: SciPy's LSODA with tight tolerances, the yardstick of the other methods.

It takes the place of the Rosenbrock method, nothing else: inputs are known in closed form, and the integration stops at the corners of
inputs and orifice tables and where lines, joints, relief valves and crossovers change their conditions.
"""

import itertools
from typing import Any

import numpy as np
from scipy.integrate import LSODA

from polydraulic.simulation.layout.methods.event_log import fill_flags, observe_flags
from polydraulic.simulation.layout.methods.known import KnownPart, Reached, Watch, breaks_of, first_piece, sizes
from polydraulic.simulation.layout.methods.text import pushed_functions
from polydraulic.simulation.solvers.spools import inputs_at

_MAX_EVALUATIONS = 5_000_000
_MAX_EVENTS = 10_000
_MAX_STEP = 0.02  # s


class _Equations:
    """The compiled equations of a part under the conditions that hold at present."""

    def __init__(self, part: KnownPart, counts: dict[str, int]) -> None:
        self._part, self._counts = part, counts
        self._n = len(part.machine.names)
        self._pushed = [part.machine.names.index(f.name) for f in pushed_functions(part.machine)]
        self._inputs = np.empty((2, part.motion.coefficients.shape[1]))
        self._f, self.free = np.empty(4 * self._n + len(self._pushed)), np.ones(2 * self._n)
        self._opened = np.empty(len(part.machine.circuits) + len(part.machine.crossovers))
        self.piece = first_piece(part.motion, part.start)
        self.conditions: Any = None

    def known(self, t: float) -> np.ndarray:
        """Inputs at a time."""
        c, start = self._part.motion.coefficients[self.piece], float(self._part.motion.starts[self.piece])
        inputs_at(c, start, t, *self._inputs)
        return self._inputs[0]

    def slope(self, t: float, y: np.ndarray) -> np.ndarray:
        self._counts["evaluations"] += 1
        part = self._part
        held = self.conditions.held
        part.module.evaluate_slow(part.valves, part.plant, held, self.free, self.known(t), y, self._f)
        return self._f.copy()

    def changed(self, t: float, y: np.ndarray) -> bool:
        part = self._part
        known = self.known(t)
        return bool(part.module.changed_at(part.valves, part.plant, self.conditions, self.free, known, y, self._f))

    def settle(self, t: float, y: np.ndarray) -> None:
        """Put a state back to its bounds and find the conditions that hold from now on."""
        part = self._part
        self.conditions = part.module.settle(part.valves, part.plant, self.known(t), y, self._f, self.free)

    def state(self, t: float, y: np.ndarray) -> np.ndarray:
        spools = self.known(t)[: self._n].copy()
        spools[self._pushed] -= y[4 * self._n :]
        return np.concatenate([spools, y[: 4 * self._n]])

    def fill_flags(self, t: float, y: np.ndarray, watch: Watch, flags: np.ndarray) -> None:
        part, known = self._part, self.known(t)
        part.module.store_opened(part.valves, part.plant, self.conditions, self.free, known, y, self._f, self._opened)
        fill_flags(self.state(t, y), self._opened, watch.limits, flags)


def integrate(
    part: KnownPart,
    y: np.ndarray,
    rtol: float,
    time: np.ndarray,
    rows: np.ndarray,
    row: int,
    watch: Watch,
    counts: dict[str, int],
) -> Reached:
    """Integrate a part of a run to a tight tolerance; see `known.Integrate`."""
    for name in ("evaluations", "events_located"):
        counts.setdefault(name, 0)
    equations, y, n = _Equations(part, counts), y.copy(), len(part.machine.names)
    scale = sizes(n, len(y) - 4 * n)
    equations.settle(part.start, y)
    if part.start == 0.0:
        equations.fill_flags(0.0, y, watch, watch.had)
    for t, end in itertools.pairwise([part.start, *breaks_of(part)]):
        equations.piece = first_piece(part.motion, t)
        while t < end:
            solver = LSODA(equations.slope, t, y, end, rtol=rtol, atol=rtol * scale, max_step=_MAX_STEP)
            happened = False
            while solver.status == "running" and not happened:
                before, y_before = solver.t, y
                message = solver.step()
                if solver.status == "failed":
                    return Reached(row, y, str(message))
                if counts["evaluations"] > _MAX_EVALUATIONS:
                    return Reached(row, y, f"more than {_MAX_EVALUATIONS} evaluations")
                dense, t, y = solver.dense_output(), solver.t, solver.y.copy()
                happened = equations.changed(t, y)
                if happened:
                    low = before
                    while t - low > 1e-12 * max(1.0, t):
                        middle = 0.5 * (low + t)
                        t, low = (middle, low) if equations.changed(middle, dense(middle)) else (t, middle)
                    y = dense(t)
                while row < len(time) and time[row] <= t:
                    rows[row, : 5 * n] = equations.state(time[row], dense(time[row]))
                    row += 1
                if happened:
                    counts["events_located"] += 1
                    if counts["events_located"] > _MAX_EVENTS:
                        return Reached(row, y, f"more than {_MAX_EVENTS} events")
                    equations.settle(t, y)
                equations.fill_flags(t, y, watch, watch.flags)
                states = equations.state(before, y_before), equations.state(t, y)
                observe_flags(watch.log, watch.had, watch.flags, before, t, *states, watch.limits)
    return Reached(row, y)
