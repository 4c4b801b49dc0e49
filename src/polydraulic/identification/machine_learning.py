"""Networks of a whole machine from a log of its work: three inlets by region, three outlets."""

from collections.abc import Sequence

import numpy as np

from polydraulic.flow.network_slots import BOOM_IN, BOTH, PASSED, k_out, q_in
from polydraulic.identification.machine_log import BELOW_RELIEF, ROOT_LEAST
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

ROWS, REGIONS = 30_000, 16  # that a network learns from, and regions it may find
_SEED = 1000  # of the choice of rows
_SMALL = 0.03  # opening, as a share of the active travel, below which errors count alike
CELL = 60  # rows that a part of an outlet's curve needs


def learn(
    machine: Machine,
    log: Table,
    *,
    max_regions: int = REGIONS,
    max_rows: int = ROWS,
    progress: Progress = quiet,
) -> list[Model]:
    """Networks of all circuits from measurements; what must be known is the pumps' flow, relief setting, and the deadband.

    Parameters
    ----------
    machine : Machine
    log : Table
        From `by_port`.
    max_regions : int
        That the network of an inlet may find.
    max_rows : int
        That a network learns from.
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
        rows = below[_chosen(log[f"{link}.travel"][below] > machine.spool.deadband, max_rows, rng)]
        settings = AbductiveRegressor(max_layers=3, output_bounds=(0.0, high))  # holds where it has seen rows
        models.append(_fit(settings, log, inputs, output, rows, max_regions))
    for link in LINKS:
        progress(f"{link}.k_out", len(models), 2 * len(LINKS))
        models.append(_learn_outlet(machine, log, link, max_rows, rng))
    return models


def _learn_outlet(machine: Machine, log: Table, link: str, max_rows: int, rng: np.random.Generator) -> Model:
    """Conductance of an outlet over the spool: a cubic in each part of its travel that was visited."""
    rows = rng.permutation(np.flatnonzero(log[f"{link}.root_p_out"] > ROOT_LEAST))[:max_rows]
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


def _chosen(active: np.ndarray, max_rows: int, rng: np.random.Generator) -> np.ndarray:
    """Rows to learn from: those with an open valve say most."""
    on, off = np.flatnonzero(active), np.flatnonzero(~active)
    return np.concatenate([rng.permutation(on)[:max_rows], rng.permutation(off)[: max_rows // 5]])


def _fit(
    settings: AbductiveRegressor,
    log: Table,
    inputs: Sequence[Variable],
    output: Variable,
    rows: np.ndarray,
    max_regions: int,
) -> Model:
    learner = RegionRegressor(settings, max_regions=max_regions, min_rows=min(150, max(20, len(rows) // 40)))
    X, y = log.matrix([variable.name for variable in inputs])[rows], log[output.name][rows]
    return learner.fit(X, y).to_model(inputs, output)
