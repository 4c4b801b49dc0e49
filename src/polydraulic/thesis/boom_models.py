"""Networks of the boom circuit: what is learnt from which inputs, in which regions (thesis 4.2)."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table
from polydraulic.thesis.excavator import PRESSURE_HIGH, pump_of, sample_boom, spool_of

SEED = 215
N_ROWS = 10_000  # as many as the thesis used for its perceptrons; it does not print the number for its networks

# The thesis' setting: half the variance as prior, nodes as they were grown. Ours is the learner's default.
HISTORICAL: dict[str, Any] = {
    "cpm": 1.0,
    "prior_variance": "half-variance",
    "carve": False,
    "refine": False,
    "leave_one_out": False,
}


class BoomModels(NamedTuple):
    """Fitted networks of the boom circuit."""

    q_in: Model
    q_out: Model
    p_pump: Model


def fit_columns(
    estimator: AbductiveRegressor,
    table: Table,
    inputs: Sequence[str],
    output: str,
    edges: dict[int, list[float]],
) -> Model:
    """Fit columns of a table by region, and name the model after them."""
    X, y = table.matrix(inputs), table[output]
    regressor = RegionRegressor(estimator, edges=edges).fit(X, y)
    return regressor.to_model([Variable(n, table.unit(n)) for n in inputs], Variable(output, table.unit(output)))


def fit_boom(
    machine: LayoutMachine,
    rng: np.random.Generator,
    *,
    n: int = N_ROWS,
    pressure_high: float = PRESSURE_HIGH,
    **settings: Any,
) -> BoomModels:
    """Sample the boom circuit without its relief valve and fit input flow, output flow and pump pressure by region.

    Parameters
    ----------
    machine : LayoutMachine
    rng : numpy Generator
    n : int
        Rows of the database.
    pressure_high : float, Pa
        Upper end of the line pressures.
    **settings
        Of `AbductiveRegressor`.
    """
    table = sample_boom(machine, n, rng=rng, pressure=(0.0, pressure_high), relief=False)
    spool, flow, valve = spool_of(machine), pump_of(machine, "boom").flow, machine.function("boom").valve
    travel = spool.end
    cuts = [spool.deadband, spool.bypass_closed]
    both_sides = [-cuts[1], -cuts[0], *cuts]
    root_high = float(np.sqrt(pressure_high - machine.tank.return_pressure))
    q_out_high = max(valve.outlet_positive + valve.outlet_negative) * root_high

    def estimator(domain: list[tuple[float, float]], high: float) -> AbductiveRegressor:
        return AbductiveRegressor(domain=domain, output_bounds=(0.0, high), **settings)

    over_inlet = [(0.0, travel), (0.0, pressure_high)]
    over_outlet = [(-travel, travel), (0.0, root_high)]
    inlet = ["boom.travel", "boom.p_in"]
    return BoomModels(
        q_in=fit_columns(estimator(over_inlet, flow), table, inlet, "boom.q_in", {0: cuts}),
        q_out=fit_columns(
            estimator(over_outlet, q_out_high),
            table,
            ["boom.spool", "boom.root_p_out"],
            "boom.q_out",
            {0: both_sides},
        ),
        p_pump=fit_columns(estimator(over_inlet, 10.0 * pressure_high), table, inlet, "boom.p_pump", {0: cuts}),
    )
