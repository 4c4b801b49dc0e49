"""Rosenbrock method for a machine of any layout, with steps of its own choice, for inputs that are known in advance.

Steps end where a spool passes a knot of its tables or an input has a corner, and where a line pressure meets or leaves its bounds, a joint its
stops, a pump its relief pressure, found by bisection on the dense output, the cubic through both ends of a step with their
slopes. Between such points everything is smooth, and a step has its order. The loop is the page `rosenbrock`; each
step solves linear systems with the true Jacobian, the page `jacobian`.
"""

from typing import Any

import numpy as np

from polydraulic.simulation.layout.methods.known import KnownPart, Reached, Watch, breaks_of, first_piece, sizes
from polydraulic.simulation.solvers.adaptive import DONE, FAILURES, RODAS

_COUNTS = ("steps", "steps_rejected", "events_located")


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
    """Integrate a part of a run; see `known.Integrate`."""
    module, machine, motion = part.module, part.machine, part.motion
    work = step_scratch(
        module, len(machine.names), motion.coefficients.shape[1], len(machine.circuits) + len(machine.crossovers)
    )
    work.y[:] = y
    numbers = np.array([*(counts.get(name, 0) for name in _COUNTS), row], dtype=np.int64)
    status = module.run_rosenbrock(
        part.valves, part.plant, part.slopes, RODAS, motion, breaks_of(part), first_piece(motion, part.start), part.start,
        rtol, time, rows, numbers, watch.log, watch.limits, watch.had, watch.flags, work,
    )  # fmt: skip
    counts |= {name: int(number) for name, number in zip(_COUNTS, numbers, strict=False)}
    return Reached(int(numbers[-1]), work.y.copy(), "" if status == DONE else FAILURES[status])


def step_scratch(module: Any, n: int, n_input: int, n_valve: int) -> Any:
    """Scratch for a run of a machine with `n` functions; `n_valve` relief valves and crossovers open and shut."""
    y, f, y_new, f_new, y_stage, f_stage = np.zeros((6, 4 * n))
    return module.Work(
        y=y, f=f, y_new=y_new, f_new=f_new, y_stage=y_stage, f_stage=f_stage,
        stages=np.zeros((len(RODAS.time), 4 * n)), cubic=np.zeros((3, 4 * n)), free=np.ones(2 * n), scale=sizes(n),
        known=np.zeros(n_input), known_rate=np.zeros(n_input), inside=np.zeros(n_input), unused=np.zeros(n_input),
        by_position=np.zeros((n, n)), by_rate=np.zeros((n, n)), matrix=np.zeros((2 * n, 2 * n)),
        order=np.zeros(2 * n, dtype=np.int64), right=np.zeros(2 * n),
        before=np.zeros(5 * n), after=np.zeros(5 * n), opened=np.zeros(n_valve),
    )  # fmt: skip
