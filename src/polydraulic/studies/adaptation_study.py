"""Networks that follow a machine which has changed: a torque limit that they never saw, a pump that wears.

An operator works; the exact machine gives what would be measured: spool travels, line and pump pressures and input flows at
every step. Rows with a pump at relief are left out: they say nothing of the networks of constant flow.
After each minute the adapted networks take the place of the fitted ones in the machine's model and are judged by runs of other
operators. The model knows the pump's flow when new, and nothing of the change.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from polydraulic.flow import exact_flow, polynomial_flow
from polydraulic.flow.places import BOTH
from polydraulic.flow.polynomial import shipped_models
from polydraulic.flow.sample import sample_flow
from polydraulic.networks import Model
from polydraulic.networks.adaptation import Adapter
from polydraulic.parameters import LINKS, Machine, random_operator
from polydraulic.simulation import simulate
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table

MINUTE, STEP = 60.0, 5e-3  # s
OPERATOR, JUDGES = 1000, tuple(range(2000, 2006))  # seeds: the operator's first minute; operators who judge
MEMORY = 0.9999  # forgetting: 10 000 steps are 50 s
TRUST = 0.8  # of the pump's flow: a torque limit takes more than half of it
ORDER = 2
AT_RELIEF = 0.98  # of the relief pressure, above which a pump's valve counts as open


@dataclass
class AdaptiveFlow:
    """Networks of the package, and adapters of those that give input flows.

    Attributes
    ----------
    machine : Machine
        As the model knows it.
    adapters : dict from output to Adapter
    others : list of Model
        Networks that stay as they are.
    """

    machine: Machine
    adapters: dict[str, Adapter]
    others: list[Model] = field(default_factory=list)

    def model(self) -> Any:
        """Flow model with the networks as they are now."""
        return polynomial_flow(self.machine, models=[*(a.model() for a in self.adapters.values()), *self.others])

    def take_in(self, run: Table) -> None:
        """Learn from what was measured in a run."""
        for output, adapter in self.adapters.items():
            adapter.update(*measurements(self.machine, run, adapter.model(), output))


def adaptive_flow(machine: Machine) -> AdaptiveFlow:
    """Adapters for the package's networks, of which none has seen a torque limit."""
    models = shipped_models()
    inlets = {f"{link}.q_in" for link in LINKS}
    return AdaptiveFlow(
        machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=False)),
        {
            model.output.name: Adapter(model, forgetting=MEMORY, trust=TRUST, order=ORDER)
            for model in models
            if model.output.name in inlets
        },
        [model for model in models if model.output.name not in inlets],
    )


def measurements(machine: Machine, run: Table, model: Model, output: str) -> tuple[np.ndarray, np.ndarray]:
    """Inputs (n_row, n_input) and output (n_row,) of an input-flow network from a run, in SI, below relief."""
    known = {f"{link}.travel": np.abs(run[f"{link}.spool"]) for link in LINKS}
    known |= {f"{link}.p_in": run[f"{link}.p_in"] for link in LINKS}
    closed = known[BOTH[0].name] > machine.spool.bypass_closed
    known["series.q_passed"] = np.where(closed, 0.0, machine.pumps.series_flow - run["swing.q_in"])
    pump = "boom" if output == "boom.q_in" else "series"
    below = run[f"{pump}.p_pump"] < AT_RELIEF * machine.pumps.relief
    return np.column_stack([known[variable.name] for variable in model.inputs])[below], run[output][below]


def operator_run(machine: Machine, seed: int, seconds: float = MINUTE) -> Table:
    """Exact run of a random operator."""
    return simulate(machine, exact_flow(machine), random_operator(seed, seconds), dt=STEP)


def torque_limit_study(
    machine: Machine, *, minutes: int = 10, judges: Sequence[int] = JUDGES, seconds: float = MINUTE
) -> Table:
    """Networks that never saw a torque limit learn it while an operator works.

    Parameters
    ----------
    machine : Machine
    minutes : int
        Of operation to learn from.
    judges : sequence of int
        Seeds of the operators who judge.
    seconds : float, s
        Of a judge's run.

    Returns
    -------
    Table
        A row a minute, the first before any learning. ``LINK.fitted`` and ``LINK.adapted`` are rms errors of the input flows
        in m3/s at the states of the exact runs; ``tip.fitted`` and ``tip.adapted`` medians over the judges of the largest distance of
        the end-effector from the exact run, in m; ``tip.worst_fitted`` and ``tip.worst_adapted`` the largest of all.
    """
    limited = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=True))
    return _followed([limited] * (minutes + 1), judges, seconds)


def worn_pump_study(
    machine: Machine,
    *,
    loss: float = 0.1,
    minutes: int = 10,
    after: int = 5,
    judges: Sequence[int] = JUDGES,
    seconds: float = MINUTE,
) -> Table:
    """Both pumps lose delivery while an operator works; then they are replaced, and nobody says so.

    Parameters
    ----------
    machine : Machine
    loss : float
        Share of the flow that is lost at the end, in equal parts a minute.
    minutes : int
        Of wear.
    after : int
        Minutes with new pumps.
    judges, seconds
        As `torque_limit_study`.

    Returns
    -------
    Table
        As `torque_limit_study`, each minute judged on the machine as it then is; ``delivery`` is what is left of the pumps' flow.
    """
    shares = [1.0 - loss * minute / minutes for minute in range(minutes + 1)] + [1.0] * after
    return _followed([_worn(machine, share) for share in shares], judges, seconds, shares)


def _worn(machine: Machine, share: float) -> Machine:
    pumps = machine.pumps
    return machine._replace(
        pumps=pumps._replace(
            boom_flow=share * pumps.boom_flow, series_flow=share * pumps.series_flow, torque_limit_enabled=False
        )
    )


def _followed(
    machines: Sequence[Machine], judges: Sequence[int], seconds: float, shares: Sequence[float] | None = None
) -> Table:
    """Errors before learning and after each minute; the machine as it is at the end of each minute."""
    adaptive, rows = adaptive_flow(machines[0]), []
    fitted = adaptive.model()
    for minute, machine in enumerate(machines):
        if minute:
            adaptive.take_in(operator_run(machine, OPERATOR + minute))
        rows.append(_judged(machine, {"fitted": fitted, "adapted": adaptive.model()}, judges, seconds))
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    units = {name: "m" if name.startswith("tip") else "m3/s" for name in columns}
    extra = {} if shares is None else {"delivery": np.array(shares)}
    return Table(
        {"minute": np.arange(len(rows), dtype=np.float64), **extra, **columns},
        {"minute": "min", "delivery": "", **units},
    )


def _judged(machine: Machine, flows: dict[str, Any], judges: Sequence[int], seconds: float) -> dict[str, float]:
    """Errors of flow models along the judges' exact runs, and of runs of their own."""
    squares: dict[str, list[np.ndarray]] = {name: [] for name in flows}
    tips: dict[str, list[float]] = {name: [] for name in flows}
    for seed in judges:
        exact = operator_run(machine, seed, seconds)
        states = [exact.matrix([f"{link}.{what}" for link in LINKS]) for what in ("spool", "p_in", "p_out", "q_in")]
        for name, flow in flows.items():
            error = sample_flow(flow, *states[:3]).q_in - states[3]
            squares[name].append(np.mean(error * error, axis=0))
            own = simulate(machine, flow, random_operator(seed, seconds), dt=STEP)
            tips[name].append(float(effector_distance(exact, own).max()))
    found: dict[str, float] = {}
    for name in flows:
        rms = np.sqrt(np.mean(squares[name], axis=0)).tolist()
        found |= {f"{link}.{name}": value for link, value in zip(LINKS, rms, strict=True)}
        found[f"tip.{name}"], found[f"tip.worst_{name}"] = float(np.median(tips[name])), max(tips[name])
    return found
