"""Perceptrons of the boom circuit (thesis 4.3): input flow as one network, outlet conductance by region."""

from typing import NamedTuple

import numpy as np

from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.perceptron.perceptron_regressor import PerceptronRegressor, hidden_unit_sweep
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table
from polydraulic.thesis.boom_models import N_ROWS, SEED
from polydraulic.thesis.excavator import PRESSURE_HIGH, boom_table, pump_of, sample_boom, spool_of

HIDDEN_Q_IN, HIDDEN_K_OUT = 15, 7  # as printed
HIDDEN_UNITS = (2, 4, 6, 8, 10, 12, 15, 20, 25)  # of the sweep
_INLET = ("boom.travel", "boom.p_in")


class PerceptronModels(NamedTuple):
    """Fitted perceptrons of the boom circuit."""

    q_in: Model
    k_out: Model


def fit_perceptrons(machine: LayoutMachine, rng: np.random.Generator) -> PerceptronModels:
    """Sample the boom circuit without its relief valve and train what section 4.3 trains.

    Input flow is one network over all spool travels; Q_pop(x) = Q_o / sqrt(P_o - P_e) of Eq. (7) has one for each part
    of its curve.
    """
    table = sample_boom(machine, N_ROWS, rng=rng, relief=False)
    q_in = _estimator(machine, HIDDEN_Q_IN).fit(table.matrix(_INLET), table["boom.q_in"])
    spool, q_pop = _outlet(machine, rng)
    *cuts, travel = spool_of(machine)
    outlet = PerceptronRegressor(
        hidden_units=HIDDEN_K_OUT,
        domain=[(-travel, travel)],
        output_bounds=(0.0, float(q_pop.max())),
        random_state=SEED,
    )
    k_out = RegionRegressor(outlet, edges={0: [-cuts[1], -cuts[0], *cuts]}).fit(spool[:, None], q_pop)
    return PerceptronModels(
        q_in.to_model([Variable(name, table.unit(name)) for name in _INLET], Variable("boom.q_in", "m3/s")),
        k_out.to_model([Variable("boom.spool", "m")], Variable("boom.k_out", "m3/s/Pa^0.5")),
    )


def sweep_hidden_units(machine: LayoutMachine, rng: np.random.Generator) -> Table:
    """Rms error of input flow in m3/s over the number of hidden units, on training rows and on rows held out (Fig 4-18)."""
    table = sample_boom(machine, N_ROWS, rng=rng, relief=False)
    settings = _estimator(machine, HIDDEN_Q_IN).get_params()
    del settings["hidden_units"]
    points = hidden_unit_sweep(table.matrix(_INLET), table["boom.q_in"], HIDDEN_UNITS, **settings | {"n_starts": 1})
    columns = {name: np.array([float(getattr(point, name)) for point in points]) for name in points[0]._fields}
    return Table(columns, {name: "m3/s" for name in list(columns)[1:]})


def _estimator(machine: LayoutMachine, hidden_units: int) -> PerceptronRegressor:
    domain = [(0.0, spool_of(machine).end), (0.0, PRESSURE_HIGH)]
    return PerceptronRegressor(
        hidden_units=hidden_units, domain=domain, output_bounds=(0.0, pump_of(machine, "boom").flow), random_state=SEED
    )


def _outlet(machine: LayoutMachine, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Random spool displacements and Q_pop there."""
    travel = spool_of(machine).end
    spool = rng.uniform(-travel, travel, N_ROWS)
    high = np.full(N_ROWS, PRESSURE_HIGH)
    table = boom_table(machine, spool, np.zeros(N_ROWS), high, relief=False)
    return spool, table["boom.q_out"] / table["boom.root_p_out"]
