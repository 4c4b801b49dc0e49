"""Networks of the series circuit in the thesis' setting: one for each section of Table 3, from random points (5.1, 5.2)."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.flow.dispatch import FlowModel
from polydraulic.flow.layout.database import outlet_at
from polydraulic.flow.layout.slots import everything, outlet
from polydraulic.flow.network_slots import q_in
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.partition import Split
from polydraulic.networks.model.table import Network
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.thesis.boom_models import HISTORICAL, N_ROWS, SEED
from polydraulic.thesis.excavator import LINKS, PRESSURE_HIGH, SERIES, pump_of, spool_of, without_relief

SECTIONS = ("A", "B", "C", "D", "E")


class Section(NamedTuple):
    """A section of Table 3: ranges of travel in m, and whether swing and stick get flow."""

    swing: tuple[float, float]
    stick: tuple[float, float]
    active: tuple[bool, bool]


def sections(machine: LayoutMachine) -> dict[str, Section]:
    """Table 3: by the travels of swing and stick."""
    opens, shut, end = spool_of(machine)
    return {
        "A": Section((0.0, opens), (0.0, opens), (False, False)),
        "B": Section((0.0, opens), (opens, end), (False, True)),
        "C": Section((opens, shut), (0.0, opens), (True, False)),
        "D": Section((opens, shut), (opens, end), (True, True)),
        "E": Section((shut, end), (0.0, end), (True, False)),
    }


def series_flows(machine: LayoutMachine, X: np.ndarray, *, relief: bool = False) -> np.ndarray:
    """Exact flows into swing and stick, (n_point, 2) in m3/s, at (swing travel, stick travel, swing p_in, stick p_in)."""
    return flows_at(machine if relief else without_relief(machine), "exact", X)


def flows_at(machine: LayoutMachine, model: str | FlowModel, X: np.ndarray) -> np.ndarray:
    """Flows of any flow model into swing and stick, (n_point, 2) in m3/s, at the same points."""
    spool, pressure = np.zeros((len(X), 3)), np.zeros((len(X), 3))
    places = [LINKS.index(link) for link in SERIES]
    spool[:, places], pressure[:, places] = X[:, :2], X[:, 2:]
    return sample_flow(machine, model, spool, pressure, np.zeros((len(X), 3))).q_in[:, places]


def grow_series(
    machine: LayoutMachine,
    settings: dict[str, Any] = HISTORICAL,
    *,
    n: int = N_ROWS,
    pressure_high: float = PRESSURE_HIGH,
) -> list[Model]:
    """Networks of the input flows of swing and stick, one per section, from `n` random points in each.

    The circuit is that of Eqs (8)-(13): without relief valve, with the torque limit that the machine has.

    Parameters
    ----------
    machine : LayoutMachine
    settings : dict
        Of `AbductiveRegressor`.
    n : int
        Points a section.
    pressure_high : float, Pa
        Upper end of the line pressures.
    """
    by_section = []
    for place, section in enumerate(sections(machine).values()):
        rng = np.random.default_rng([SEED, place])
        box = [section.swing, section.stick, (0.0, pressure_high), (0.0, pressure_high)]
        low, high = np.transpose(box)
        X = rng.uniform(low, high, size=(n, len(box)))
        flows = series_flows(machine, X)
        grown = [
            AbductiveRegressor(domain=box, output_bounds=(0.0, pump_of(machine, "series").flow), **settings).fit(X, q)
            if active
            else None
            for q, active in zip(flows.T, section.active, strict=True)
        ]
        idle = Network((), tuple(low), (1.0,) * 4, tuple(low), tuple(high), 0.0, 1.0)
        by_section.append([idle if found is None else found.network_ for found in grown])
    opens, shut, _ = spool_of(machine)
    table_3 = Split(0, shut, Split(0, opens, Split(1, opens, 0, 1), Split(1, opens, 2, 3)), 4)
    training: dict[str, object] = {"rows": n, "sections": list(SECTIONS), **settings}
    return [
        Model(everything(SERIES), q_in(link), tuple(networks[place] for networks in by_section), table_3, training)
        for place, link in enumerate(SERIES)
    ]


def grow_outlets(
    machine: LayoutMachine,
    settings: dict[str, Any] = HISTORICAL,
    *,
    n: int = N_ROWS,
    edges: Sequence[float] | None = None,
) -> list[Model]:
    """Networks of Q_pop(x), Eq. (7), by the parts of its curve: between `edges` in m, those of Table 3 if not given."""
    opens, shut, travel = spool_of(machine)
    edges = [-shut, -opens, opens, shut] if edges is None else list(edges)
    models = []
    for link in SERIES:
        rng = np.random.default_rng([SEED, len(SECTIONS), LINKS.index(link)])
        X = rng.uniform(-travel, travel, size=(n, 1))
        y = outlet_conductances(machine, link, X[:, 0])
        learner = AbductiveRegressor(domain=[(-travel, travel)], output_bounds=(0.0, float(y.max())), **settings)
        fitted = RegionRegressor(learner, edges={0: edges}).fit(X, y)
        output, inputs = outlet(link)[0]
        models.append(fitted.to_model(inputs, output))
    return models


def outlet_conductances(machine: LayoutMachine, link: str, spool: np.ndarray) -> np.ndarray:
    """Exact conductance of a link's outlet, (n_point,) in m3/s/Pa^0.5, at spool displacements in m."""
    return outlet_at(machine.function(link).valve, spool)
