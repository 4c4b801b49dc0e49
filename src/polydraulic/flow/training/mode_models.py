"""Networks of the pump's modes, each learnt from a pump that knows no other: constant flow, open relief valve, torque limit.

Without the kinks between modes, which are curved, each is smooth between borders that are known and the closing of a check valve.
A flow above the pump's counts as the pump's: the least of the modes is never more.
"""

from typing import NamedTuple

import numpy as np
from sklearn.base import clone

from polydraulic import units
from polydraulic.flow.exact import ExactFlow, exact_flow
from polydraulic.flow.network_slots import (
    BOOM_IN,
    BOOM_LIMITED,
    BOTH,
    PASSED,
    STICK_LIMITED,
    STICK_RELIEF,
    SWING_LIMITED,
    Place,
    k_in,
    q_in,
)
from polydraulic.flow.sample import sample_fed
from polydraulic.flow.training.circuit_models import SEED, Target, input_flow, pressure_boxes
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model
from polydraulic.networks.regions.learn_from import learn_from
from polydraulic.parameters.schema import CIRCUITS, Machine, Pumps
from polydraulic.progress import Progress, quiet

_ALWAYS_OPEN = 1e3  # times its flow, a pump's relief valve is open at any spool travel
_UP_TO = 16.0  # times its flow, the law of the torque limit goes on below its start: no flow of interest meets that end


def at_constant_flow(machine: Machine) -> ExactFlow:
    """Exact flows of pumps that know neither relief valve nor torque limit."""
    return exact_flow(machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=False)), relief=False)


def at_relief(machine: Machine) -> ExactFlow:
    """Exact flows of pumps whose relief valve is always open."""
    pumps = machine.pumps._replace(torque_limit_enabled=False)
    return exact_flow(machine._replace(pumps=_larger(pumps, _ALWAYS_OPEN)))


def at_torque_limit(machine: Machine) -> ExactFlow:
    """Exact flows of pumps that follow the law of the torque limit at all pressures, Q = flow (start / P)^exponent."""
    pumps = _larger(machine.pumps, _UP_TO)._replace(
        torque_limit_enabled=True,
        torque_limit_start=machine.pumps.torque_limit_start / _UP_TO ** (1.0 / machine.pumps.torque_limit_exponent),
    )
    return exact_flow(machine._replace(pumps=pumps), relief=False)


def _larger(pumps: Pumps, times: float) -> Pumps:
    return pumps._replace(boom_flow=times * pumps.boom_flow, series_flow=times * pumps.series_flow)


class Effort(NamedTuple):
    """How well a network is learnt."""

    tolerance: float  # m3/s
    regions: int  # at most
    rows: int  # from which a region learns
    finer: AbductiveRegressor | None = None  # settings for a last fit of all regions
    finer_rows: int | None = None


FINE = units.to_si(0.07, "in3/s")
OF_TWO = Effort(FINE, 64, 1500)
OF_THREE = Effort(FINE, 48, 1500, AbductiveRegressor(max_layers=4, carve=False), 2000)
OF_FOUR = Effort(FINE, 150, 1500, AbductiveRegressor(max_layers=5, carve=False), 2500)
OF_FOUR_LIMITED = Effort(FINE, 56, 1500, AbductiveRegressor(max_layers=4, carve=False), 2500)


def learn_inlets(machine: Machine, progress: Progress = quiet) -> list[Model]:
    """Networks of boom and swing: input flows at constant pump flow, conductances of the inlets for the open relief valve.

    Parameters
    ----------
    machine : Machine
    progress : Progress, optional
        Told the output and its largest error so far in m3/s, and how many points have been asked.
    """
    flows = [
        _learn(_boom(machine, at_constant_flow(machine), BOOM_IN), OF_TWO, progress),
        _learn(_series(machine, at_constant_flow(machine), (q_in("swing"), BOTH)), OF_FOUR, progress),
    ]
    return [*flows, *(_learn_k_in(machine, link) for link in ("boom", "swing"))]


def learn_cascade(machine: Machine, progress: Progress = quiet) -> list[Model]:
    """Networks of the stick's flow, of what reaches its valve, and with the relief valve open.

    Parameters
    ----------
    machine, progress
        As for `learn_inlets`.
    """
    free, relief, spool = at_constant_flow(machine), at_relief(machine), machine.spool
    flow, full, cuts = machine.pumps.series_flow, spool.knots[-1], [spool.deadband, spool.bypass_closed]
    pressure = pressure_boxes(machine, machine.pumps.relief)

    def at_open(X: np.ndarray) -> np.ndarray:
        first, second, root = X.T
        p_second = np.maximum(machine.pumps.relief - root * root, 0.0)
        points = np.column_stack([first, second, np.zeros(len(X)), p_second])  # the swing's pressure does not matter
        return np.minimum(input_flow(relief, points, CIRCUITS["series"], "stick"), flow)

    stick = Target(
        q_in("stick"), PASSED, lambda X: sample_fed(free.valves.stick, free.series_pump, X),
        [(0.0, flow), (0.0, full), pressure["stick"]], {"stick.travel": cuts}, flow,
    )  # fmt: skip
    stick_relief = Target(
        *STICK_RELIEF, at_open, [(0.0, spool.bypass_closed), (0.0, full), (0.0, float(np.sqrt(machine.pumps.relief)))],
        {"swing.travel": cuts[:1], "stick.travel": cuts}, flow,
    )  # fmt: skip
    return [_learn(target, OF_THREE, progress) for target in (stick, stick_relief)]


def learn_limited(machine: Machine, progress: Progress = quiet) -> list[Model]:
    """Networks of the input flows at the torque limit.

    Parameters
    ----------
    machine, progress
        As for `learn_inlets`. The law of the limit counts, whether it is enabled or not.
    """
    exact = at_torque_limit(machine)
    swing, stick = (_series(machine, exact, place) for place in (SWING_LIMITED, STICK_LIMITED))
    # past the closing of the swing's bypass nothing reaches the stick
    stick = stick._replace(
        box=[(0.0, machine.spool.bypass_closed), *stick.box[1:]],
        edges=stick.edges | {"swing.travel": [machine.spool.deadband]},
    )
    return [
        _learn(_boom(machine, exact, BOOM_LIMITED), OF_TWO, progress),
        *(_learn(target, OF_FOUR_LIMITED, progress) for target in (swing, stick)),
    ]


def _boom(machine: Machine, exact: ExactFlow, place: Place) -> Target:
    high, spool = machine.pumps.boom_flow, machine.spool
    return Target(
        *place, lambda X: np.minimum(input_flow(exact, X, ("boom",), "boom"), high),
        [(0.0, spool.knots[-1]), pressure_boxes(machine, machine.pumps.relief)["boom"]],
        {"boom.travel": [spool.deadband, spool.bypass_closed]}, high,
    )  # fmt: skip


def _series(machine: Machine, exact: ExactFlow, place: Place) -> Target:
    high, spool = machine.pumps.series_flow, machine.spool
    pressure, cuts = pressure_boxes(machine, machine.pumps.relief), [spool.deadband, spool.bypass_closed]
    full, link = (0.0, spool.knots[-1]), place[0].name.split(".")[0]
    return Target(
        *place, lambda X: np.minimum(input_flow(exact, X, CIRCUITS["series"], link), high),
        [full, full, pressure["swing"], pressure["stick"]], {"swing.travel": cuts, "stick.travel": cuts}, high,
    )  # fmt: skip


def _learn(target: Target, effort: Effort, progress: Progress) -> Model:
    bounds = (0.0, target.high)
    finer = None if effort.finer is None else clone(effort.finer).set_params(output_bounds=bounds)
    return learn_from(
        target.function, target.box, tolerance=effort.tolerance, edges=target.edges, budget=10_000_000,
        max_regions=effort.regions, rows=effort.rows, estimator=AbductiveRegressor(max_layers=3, output_bounds=bounds),
        finer=finer, finer_rows=effort.finer_rows, inputs=target.inputs, output=target.output, random_state=SEED,
        progress=lambda what, asked, most: progress(f"{target.output.name}: {what}", asked, most),
    ).model  # fmt: skip


def _learn_k_in(machine: Machine, link: str) -> Model:
    """Conductance of an inlet, from the flow at relief pressure into an empty line (Eq. 1)."""
    exact, spool, root = at_relief(machine), machine.spool, np.sqrt(machine.pumps.relief)
    output, inputs = k_in(link)
    high = max(getattr(machine, link).valve.inlet)

    def conductance(X: np.ndarray) -> np.ndarray:
        return input_flow(exact, np.column_stack([X, np.zeros(len(X))]), (link,), link) / root

    return learn_from(
        conductance, [(0.0, spool.knots[-1])], tolerance=1e-5 * high, rows=300,
        edges={0: [spool.deadband, spool.bypass_closed]},
        estimator=AbductiveRegressor(max_layers=1, kinds=("single",), output_bounds=(0.0, high)),
        inputs=inputs, output=output, random_state=SEED,
    ).model  # fmt: skip
