"""Networks that follow a machine which has changed: a torque limit that they never saw, a pump that wears.

An operator works on the exact machine; sensors read spools, port and pump pressures and input flows. They are exact, or have what
real ones have: noise, delays, silent times. Means over a short time are learnt from, of times in which the spools nearly rest: near
the deadband flows are steep, and what a moving spool does is read by no two sensors at the same moment. Times with a pump at
relief are left out: they say nothing of the networks of constant flow.
After each minute the adapted networks take the place of the fitted ones in the machine's model and are judged by runs of other
operators. The model knows the pump's flow when new, and nothing of the change.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from polydraulic.flow.dispatch import build_flow
from polydraulic.flow.polynomial import shipped_models
from polydraulic.measure.bench.sensors import Reading, Sensor
from polydraulic.networks.adaptation import Adapter
from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import random_operator
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of, with_pumps
from polydraulic.thesis.measured.readings import RANGES, RASTER

MINUTE, STEP = 60.0, 5e-3  # s
OPERATOR, JUDGES = 1000, tuple(range(2000, 2006))  # seeds: the operator's first minute; operators who judge
READ = (
    *(f"{link}.{what}" for link in LINKS for what in ("spool", "p_a", "p_b", "q_in")),
    "boom.p_pump",
    "series.p_pump",
)
WINDOW = 10  # readings, 0.2 s, that a measurement is the mean of
STILL = 0.03  # of a spool sensor's range, by which the means of both halves of a window may differ
MEMORY = 0.9996  # forgetting: 2500 measurements are 50 s
TRUST = 0.8  # of the pump's flow: a torque limit takes more than half of it
ORDER = 2
CAUTION = 2.5  # measurements, 0.05 s
AT_RELIEF = 0.98  # of the relief pressure, above which a pump's valve counts as open


class Sensors(NamedTuple):
    """What all sensors have in common.

    Attributes
    ----------
    noise : float
        Standard deviation, as a share of the range.
    delay, flow_delay : float, s
        Dead time of spool and pressure sensors, and of flow sensors.
    dropout : float
        Share of the time in which a sensor gives nothing.
    """

    noise: float = 0.0
    delay: float = 0.0
    flow_delay: float = 0.0
    dropout: float = 0.0


SENSORS = {"exact": Sensors(), "real": Sensors(noise=0.003, delay=0.01, flow_delay=0.04, dropout=0.05)}


@dataclass
class AdaptiveFlow:
    """Networks of the package, and adapters of those that give input flows.

    Attributes
    ----------
    machine : LayoutMachine
        As the model knows it.
    adapters : dict from output to Adapter
    others : list of Model
        Networks that stay as they are.
    """

    machine: LayoutMachine
    adapters: dict[str, Adapter]
    others: list[Model] = field(default_factory=list)

    def model(self) -> Any:
        """Flow model with the networks as they are now."""
        return build_flow(
            "polynomial", self.machine, models=[*(a.model() for a in self.adapters.values()), *self.others]
        )

    def take_in(self, read: Table) -> None:
        """Learn from what sensors read."""
        for output, adapter in self.adapters.items():
            adapter.update(*measurements(self.machine, read, adapter.model(), output))


def adaptive_flow(machine: LayoutMachine, sensors: Sensors = SENSORS["exact"]) -> AdaptiveFlow:
    """Adapters for the package's networks, of which none has seen a torque limit."""
    models = shipped_models()
    inlets = {f"{link}.q_in" for link in LINKS}
    noise = sensors.noise * RANGES["m3/s"] / float(np.sqrt(WINDOW))
    return AdaptiveFlow(
        with_pumps(machine, torque_limit_enabled=False),
        {
            model.output.name: Adapter(model, forgetting=MEMORY, trust=TRUST, order=ORDER, caution=CAUTION, noise=noise)
            for model in models
            if model.output.name in inlets
        },
        [model for model in models if model.output.name not in inlets],
    )


def readings(run: Table, sensors: Sensors, seed: int) -> Table:
    """What sensors read of a run, in SI; NaN where one is silent."""
    read = {}
    for place, column in enumerate(READ):
        unit = run.unit(column)
        sensor = Sensor(
            column,
            column,
            unit,
            RASTER,
            noise=sensors.noise * RANGES[unit],
            delay=sensors.flow_delay if unit == "m3/s" else sensors.delay,
            dropout=sensors.dropout,
            dropout_length=0.5,
        )
        time, read[column] = Reading(sensor, np.random.default_rng([seed, place])).of(run)
    return Table({"time": time, **read}, {})


def measurements(
    machine: LayoutMachine, read: Table, model: Model, output: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (n_row, n_input), output and weight (n_row,) for an input-flow network, in SI, from what sensors read.

    Each row is a mean over `WINDOW` readings. Its weight is 0 if one of them is missing, the pump was at relief, or a spool moved.
    """
    passed, known = "series.q_passed", {}
    inputs = [variable.name for variable in model.inputs]
    for link in LINKS:
        spool, p_a, p_b = (read[f"{link}.{what}"] for what in ("spool", "p_a", "p_b"))
        known[f"{link}.travel"] = np.abs(spool)
        known[f"{link}.p_in"] = np.maximum(np.where(spool > 0.0, p_a, p_b), 0.0)
        known[f"{link}.q_in"] = read[f"{link}.q_in"]
    needed = [output, *(name for name in inputs if name != passed)]
    needed += ["swing.travel", "swing.q_in"] if passed in inputs else []
    windows = {name: sliding_window_view(known[name], WINDOW) for name in needed}
    means = {name: window.mean(axis=1) for name, window in windows.items()}
    circuit = "boom" if output == "boom.q_in" else "series"
    pump = sliding_window_view(read[f"{circuit}.p_pump"], WINDOW)
    useful = (pump.max(axis=1) < AT_RELIEF * pump_of(machine, circuit).relief) & np.all(
        np.isfinite([*means.values()]), axis=0
    )
    half = WINDOW // 2
    for name, window in windows.items():
        if name.endswith(".travel"):
            moved = np.abs(window[:, half:].mean(axis=1) - window[:, :half].mean(axis=1))
            useful &= moved < STILL * RANGES["m"]
    if passed in inputs:
        closed = means["swing.travel"] > spool_of(machine).bypass_closed
        means[passed] = np.where(closed, 0.0, pump_of(machine, "series").flow - means["swing.q_in"])
    return np.column_stack([means[name] for name in inputs]), means[output], useful.astype(np.float64)


def operator_run(machine: LayoutMachine, seed: int, seconds: float = MINUTE) -> Table:
    """Exact run of a random operator."""
    return simulate(machine, "exact", random_operator(seed, seconds), dt=STEP)


def torque_limit_study(
    machine: LayoutMachine, *, minutes: int = 10, judges: Sequence[int] = JUDGES, seconds: float = MINUTE
) -> Table:
    """Networks that never saw a torque limit learn it while an operator works.

    Parameters
    ----------
    machine : LayoutMachine
    minutes : int
        Of operation to learn from.
    judges : sequence of int
        Seeds of the operators who judge.
    seconds : float, s
        Of a judge's run.

    Returns
    -------
    Table
        A row a minute, the first before any learning. ``LINK.fitted`` and ``LINK.SENSORS``, for networks that stay as they are and
        those that learn from each kind of `SENSORS`, are rms errors of the input flows in m3/s at the states of the exact runs;
        ``tip.fitted`` and ``tip.SENSORS`` medians over the judges of the largest distance of the end-effector from the exact run,
        in m; ``tip.worst_fitted`` and ``tip.worst_SENSORS`` the largest of all.
    """
    limited = with_pumps(machine, torque_limit_enabled=True)
    return _followed([limited] * (minutes + 1), judges, seconds)


def worn_pump_study(
    machine: LayoutMachine,
    *,
    loss: float = 0.1,
    minutes: int = 10,
    after: int = 5,
    judges: Sequence[int] = JUDGES,
    seconds: float = MINUTE,
) -> Table:
    """Both pumps lose delivery while an operator works; then they are replaced, and the networks are not told.

    Parameters
    ----------
    machine : LayoutMachine
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


def _worn(machine: LayoutMachine, share: float) -> LayoutMachine:
    worn = tuple(c._replace(pump=c.pump._replace(flow=share * c.pump.flow)) for c in machine.circuits)
    return with_pumps(machine._replace(circuits=worn), torque_limit_enabled=False)


def _followed(
    machines: Sequence[LayoutMachine], judges: Sequence[int], seconds: float, shares: Sequence[float] | None = None
) -> Table:
    """Errors before learning and after each minute; the machine as it is at the end of each minute."""
    adaptive = {kind: adaptive_flow(machines[0], sensors) for kind, sensors in SENSORS.items()}
    fitted, rows = adaptive_flow(machines[0]).model(), []
    for minute, machine in enumerate(machines):
        if minute:
            run = operator_run(machine, OPERATOR + minute)
            for kind, flow in adaptive.items():
                flow.take_in(readings(run, SENSORS[kind], OPERATOR + minute))
        flows = {"fitted": fitted, **{kind: flow.model() for kind, flow in adaptive.items()}}
        rows.append(_judged(machine, flows, judges, seconds))
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    units = {name: "m" if name.startswith("tip") else "m3/s" for name in columns}
    extra = {} if shares is None else {"delivery": np.array(shares)}
    return Table(
        {"minute": np.arange(len(rows), dtype=np.float64), **extra, **columns},
        {"minute": "min", "delivery": "", **units},
    )


def _judged(machine: LayoutMachine, flows: dict[str, Any], judges: Sequence[int], seconds: float) -> dict[str, float]:
    """Errors of flow models along the judges' exact runs, and of runs of their own."""
    squares: dict[str, list[np.ndarray]] = {name: [] for name in flows}
    tips: dict[str, list[float]] = {name: [] for name in flows}
    for seed in judges:
        exact = operator_run(machine, seed, seconds)
        states = [exact.matrix([f"{link}.{what}" for link in LINKS]) for what in ("spool", "p_in", "p_out", "q_in")]
        for name, flow in flows.items():
            error = sample_flow(machine, flow, *states[:3]).q_in - states[3]
            squares[name].append(np.mean(error * error, axis=0))
            own = simulate(machine, flow, random_operator(seed, seconds), dt=STEP)
            tips[name].append(float(effector_distance(exact, own).max()))
    found: dict[str, float] = {}
    for name in flows:
        rms = np.sqrt(np.mean(squares[name], axis=0)).tolist()
        found |= {f"{link}.{name}": value for link, value in zip(LINKS, rms, strict=True)}
        found[f"tip.{name}"], found[f"tip.worst_{name}"] = float(np.median(tips[name])), max(tips[name])
    return found
