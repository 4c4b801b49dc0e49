"""Networks of a whole machine from a log of its work: what sensors read -> what circuits see -> pump and valves.

What must be known is the pumps' flow and relief setting, the return pressure and the borders of spool travel; neither orifice areas
nor pump pressures. `judged_machine` says how good the networks are.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.flow.network_slots import BOOM_IN, BOTH, PASSED, k_out, q_in
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

MEASURED = ("spool", "p_a", "p_b", "q_in", "q_out")  # of each link
UNITS = {"time": "s", "segment": "1", "spool": "m", "p_a": "Pa", "p_b": "Pa", "q_in": "m3/s", "q_out": "m3/s"}
_DERIVED = {"travel": "m", "p_in": "Pa", "root_p_out": "Pa^0.5", "k_out": "m3/s/Pa^0.5", "q_passed": "m3/s"}
ROWS, REGIONS = 30_000, 16  # that a network learns from, and regions it may find
_SEED = 1000  # of the choice of rows
ROOT_LEAST = float(np.sqrt(units.to_si(75.0, "psi")))  # below it a pressure drop says little of a conductance
BELOW_RELIEF = 0.98  # above this share of the relief setting the flow falls to nothing within what a sensor can tell
_SMALL = 0.03  # opening, as a share of the active travel, below which errors count alike
CELL = 60  # rows that a part of an outlet's curve needs


class Known(NamedTuple):
    """What must be known of a machine to read its log.

    Attributes
    ----------
    deadband : float, m
        Spool travel at which valves open.
    return_pressure, relief : float, Pa
    series_flow : float, m3/s
        Of the pump of swing and stick.
    """

    deadband: float
    return_pressure: float
    relief: float
    series_flow: float

    @classmethod
    def of(cls, machine: Machine) -> "Known":
        """From a parameter set."""
        pumps = machine.pumps
        return cls(machine.spool.deadband, machine.tank.return_pressure, pumps.relief, pumps.series_flow)


def by_port(known: Known, log: Table) -> Table:
    """What circuits see, from what sensors read: pressures by what the spool connects, travels, conductances, the passed flow.

    Parameters
    ----------
    known : Known
    log : Table
        ``LINK.spool``, ``LINK.p_a``, ``LINK.p_b``, ``LINK.q_in`` and ``LINK.q_out`` of all three links, in SI; ``time`` and ``segment``
        are kept.

    Raises
    ------
    InputError
        If one of them is missing or in another unit.
    """
    names = [name for name in log.names if name in ("time", "segment")]
    columns = {name: log[name] for name in (*names, *(f"{link}.{what}" for link in LINKS for what in MEASURED))}
    for name in columns:
        si = UNITS.get(name.split(".")[-1], "")
        if log.unit(name) not in ("", si):
            raise InputError(f"column {name!r} is in {log.unit(name)!r}; a machine is learnt in SI, this in {si!r}")
    for link in LINKS:  # a shut valve passes nothing: what a sensor says of it is noise, or a joint that coasts
        shut = np.abs(columns[f"{link}.spool"]) <= known.deadband
        for port in ("q_in", "q_out"):
            columns[f"{link}.{port}"] = np.where(shut, 0.0, columns[f"{link}.{port}"])
        columns |= _ports(known, link, columns)
    columns["series.q_passed"] = np.clip(known.series_flow - columns["swing.q_in"], 0.0, known.series_flow)
    of_columns = UNITS | _DERIVED
    return Table(columns, {name: of_columns.get(name.split(".")[-1], "") for name in columns})


def _ports(known: Known, link: str, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Pressures by what the spool connects, spool travel, conductance of the outlet (Eq. 7)."""
    forward = columns[f"{link}.spool"] > 0.0
    p_a, p_b = (np.maximum(columns[f"{link}.{port}"], 0.0) for port in ("p_a", "p_b"))
    p_out = np.where(forward, p_b, p_a)
    root = np.sqrt(np.maximum(p_out - known.return_pressure, 0.0))
    return {
        f"{link}.travel": np.abs(columns[f"{link}.spool"]),
        f"{link}.p_in": np.where(forward, p_a, p_b),
        f"{link}.root_p_out": root,
        f"{link}.k_out": columns[f"{link}.q_out"] / np.maximum(root, ROOT_LEAST),
    }


def learn(machine: Machine, log: Table, progress: Progress = quiet) -> list[Model]:
    """Networks of all circuits from measurements; what must be known is the pumps' flow, relief setting, and the deadband.

    Parameters
    ----------
    machine : Machine
    log : Table
        From `by_port`.
    progress : Progress, optional
        Told each of six outputs as it begins.
    """
    rng = np.random.default_rng(_SEED)
    models: list[Model] = []
    for link, (output, inputs), high in (
        ("boom", BOOM_IN, machine.pumps.boom_flow),
        ("swing", (q_in("swing"), BOTH), machine.pumps.series_flow),
        ("stick", (q_in("stick"), PASSED), machine.pumps.series_flow),
    ):
        progress(output.name, len(models), 2 * len(LINKS))
        # a flow model lets nothing in at relief, whatever a network says
        below = np.flatnonzero(log[f"{link}.p_in"] < BELOW_RELIEF * machine.pumps.relief)
        rows = below[_chosen(log[f"{link}.travel"][below] > machine.spool.deadband, rng)]
        settings = AbductiveRegressor(max_layers=3, output_bounds=(0.0, high))  # holds where it has seen rows
        models.append(_fit(settings, log, inputs, output, rows))
    for link in LINKS:
        progress(f"{link}.k_out", len(models), 2 * len(LINKS))
        models.append(_learn_outlet(machine, log, link, rng))
    return models


def _learn_outlet(machine: Machine, log: Table, link: str, rng: np.random.Generator) -> Model:
    """Conductance of an outlet over the spool: a cubic in each part of its travel that was visited."""
    rows = rng.permutation(np.flatnonzero(log[f"{link}.root_p_out"] > ROOT_LEAST))[:ROWS]
    spool, y = log[f"{link}.spool"][rows], log[f"{link}.k_out"][rows]
    opens, shut, end = machine.spool.deadband, machine.spool.bypass_closed, machine.spool.knots[-1]
    borders = [opens, 0.5 * (opens + shut), shut, 0.5 * (shut + end)]
    settings = AbductiveRegressor(
        max_layers=1, kinds=("single",), output_bounds=(0.0, float(np.quantile(y, 0.9999)))
    )  # beyond the travel that was seen, the last value holds
    edges = visited([-border for border in reversed(borders)] + borders, spool)
    # a conductance spans three decades, and near the deadband a small one decides as much as a large one does elsewhere
    opening = np.maximum(np.abs(spool) - opens, 0.0) / (end - opens)
    learner = RegionRegressor(settings, edges={0: edges} if edges else None, max_regions=1)
    fitted = learner.fit(spool[:, None], y, 1.0 / (_SMALL + opening) ** 2)
    return fitted.to_model((Variable(f"{link}.spool", "m"),), k_out(link))


def visited(borders: Sequence[float], values: np.ndarray) -> list[float]:
    """Those of rising borders that leave at least `CELL` values on either side, up to the next one that is kept."""
    kept: list[float] = []
    low = -np.inf
    for border in borders:
        if np.sum((values > low) & (values <= border)) >= CELL:
            kept.append(border)
            low = border
    while kept and np.sum(values > kept[-1]) < CELL:
        kept.pop()
    return kept


def _chosen(active: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Rows to learn from: those with an open valve say most."""
    on, off = np.flatnonzero(active), np.flatnonzero(~active)
    return np.concatenate([rng.permutation(on)[:ROWS], rng.permutation(off)[: ROWS // 5]])


def _fit(
    settings: AbductiveRegressor, log: Table, inputs: Sequence[Variable], output: Variable, rows: np.ndarray
) -> Model:
    learner = RegionRegressor(settings, max_regions=REGIONS, min_rows=min(150, max(20, len(rows) // 40)))
    X, y = log.matrix([variable.name for variable in inputs])[rows], log[output.name][rows]
    return learner.fit(X, y).to_model(inputs, output)
