"""Networks of the pump's modes of cat215b, each learnt from a pump that knows no other: constant flow, open relief valve, torque limit.

Without the kinks between modes, which are curved, each is smooth between borders that are known and the closing of a check valve.
A flow above the pump's counts as the pump's: the least of the modes is never more.
"""

from typing import NamedTuple

import numpy as np
from sklearn.base import clone

from polydraulic import units
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.slots import inlet, inlet_limited, second_at_relief
from polydraulic.flow.network_slots import Place, k_in, q_in
from polydraulic.flow.training.circuit_models import (
    BOOM_IN,
    BOTH,
    SEED,
    SERIES,
    Borders,
    Target,
    input_flow,
    known_borders,
    pressure_boxes,
    travels,
)
from polydraulic.machine.pump import NEVER, Pump, limited_pump
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model
from polydraulic.networks.regions.learn_from import learn_from
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

_ALWAYS_OPEN = 1e3  # times its flow, a pump's relief valve is open at any spool travel
_UP_TO = 16.0  # times its flow, the law of the torque limit goes on below its start: no flow of interest meets that end


def at_constant_flow(machine: LayoutMachine, circuit: str) -> Pump:
    """A circuit's pump that knows neither relief valve nor torque limit."""
    pump = machine.circuit(circuit).pump
    return limited_pump(pump.flow, NEVER, machine.tank.return_pressure, pump._replace(torque_limit_enabled=False))


def at_relief(machine: LayoutMachine, circuit: str) -> Pump:
    """A circuit's pump whose relief valve is always open."""
    pump = machine.circuit(circuit).pump
    free = pump._replace(torque_limit_enabled=False)
    return limited_pump(_ALWAYS_OPEN * pump.flow, pump.relief, machine.tank.return_pressure, free)


def at_torque_limit(machine: LayoutMachine, circuit: str) -> Pump:
    """A circuit's pump that follows the law of the torque limit at all pressures, Q = flow (start / P)^exponent."""
    pump = machine.circuit(circuit).pump
    start = pump.torque_limit_start / _UP_TO ** (1.0 / pump.torque_limit_exponent)
    law = pump._replace(torque_limit_enabled=True, torque_limit_start=start)
    return limited_pump(_UP_TO * pump.flow, NEVER, machine.tank.return_pressure, law)


class Effort(NamedTuple):
    """How well a network is learnt."""

    tolerance: float  # m3/s
    regions: int  # at most
    rows: int  # from which a region learns
    finer: AbductiveRegressor | None = None  # settings for a last fit of all regions
    finer_rows: int | None = None


SWING_IN: Place = (q_in("swing"), BOTH)
FINE = units.to_si(0.07, "in3/s")
OF_TWO = Effort(FINE, 64, 1500)
OF_THREE = Effort(FINE, 48, 1500, AbductiveRegressor(max_layers=4, carve=False), 2000)
OF_FOUR = Effort(FINE, 150, 1500, AbductiveRegressor(max_layers=5, carve=False), 2500)
OF_FOUR_LIMITED = Effort(FINE, 56, 1500, AbductiveRegressor(max_layers=4, carve=False), 2500)


def learn_inlets(machine: LayoutMachine, progress: Progress = quiet) -> list[Model]:
    """Networks of boom and swing: input flows at constant pump flow, conductances of the inlets for the open relief valve.

    Parameters
    ----------
    machine : LayoutMachine
    progress : Progress, optional
        Told the output and its largest error so far in m3/s, and how many points have been asked.
    """
    borders = known_borders(machine)
    flows = [
        learn_mode(boom_target(machine, at_constant_flow(machine, "boom"), BOOM_IN, borders), OF_TWO, progress),
        learn_mode(series_target(machine, at_constant_flow(machine, "series"), SWING_IN, borders), OF_FOUR, progress),
    ]
    return [*flows, *(learn_k_in(machine, circuit, borders) for circuit in ("boom", "series"))]


def learn_cascade(machine: LayoutMachine, progress: Progress = quiet) -> list[Model]:
    """Networks of the stick's flow, of what reaches its valve, and with the relief valve open.

    Parameters
    ----------
    machine, progress
        As for `learn_inlets`.
    """
    return [learn_mode(target, OF_THREE, progress) for target in stick_targets(machine, known_borders(machine))]


def stick_targets(machine: LayoutMachine, borders: Borders) -> list[Target]:
    """The stick's flow, of what reaches its valve, and with the relief valve open."""
    series, valve = machine.circuit("series"), machine.function("stick").valve
    free, open_ = at_constant_flow(machine, "series"), at_relief(machine, "series")
    flow, relief, (_, bypass_closed, full) = series.pump.flow, series.pump.relief, travels(machine)
    pressure = pressure_boxes(machine)

    def at_open(X: np.ndarray) -> np.ndarray:
        first, second, root = X.T
        p_second = np.maximum(relief - root * root, 0.0)
        points = np.column_stack([first, second, np.zeros(len(X)), p_second])  # the swing's pressure does not matter
        return np.minimum(input_flow(machine, open_, points, SERIES, "stick"), flow)

    stick = Target(
        *inlet(series, "stick")[0], lambda X: sample_valves([valve], free, X[:, 1:2], X[:, 2:], X[:, 0]).q_in[:, 0],
        [(0.0, flow), (0.0, full), pressure["stick"]], {"stick.travel": borders("stick")}, flow,
    )  # fmt: skip
    stick_relief = Target(
        *second_at_relief(series), at_open, [(0.0, bypass_closed), (0.0, full), (0.0, float(np.sqrt(relief)))],
        {"swing.travel": [x for x in borders("swing") if x < bypass_closed], "stick.travel": borders("stick")}, flow,
    )  # fmt: skip
    return [stick, stick_relief]


def learn_limited(machine: LayoutMachine, progress: Progress = quiet) -> list[Model]:
    """Networks of the input flows at the torque limit.

    Parameters
    ----------
    machine, progress
        As for `learn_inlets`. The law of the limit counts, whether it is enabled or not.
    """
    law, series, borders = at_torque_limit(machine, "series"), machine.circuit("series"), known_borders(machine)
    swing, stick = (series_target(machine, law, inlet_limited(series, name), borders) for name in SERIES)
    # past the closing of the swing's bypass nothing reaches the stick
    stick = stick._replace(
        box=[(0.0, travels(machine).bypass_closed), *stick.box[1:]],
        edges=stick.edges | {"swing.travel": [travels(machine).deadband]},
    )
    boom = boom_target(
        machine, at_torque_limit(machine, "boom"), inlet_limited(machine.circuit("boom"), "boom"), borders
    )
    efforts = zip((boom, swing, stick), (OF_TWO, OF_FOUR_LIMITED, OF_FOUR_LIMITED), strict=True)
    return [learn_mode(target, effort, progress) for target, effort in efforts]


def boom_target(machine: LayoutMachine, pump: Pump, place: Place, borders: Borders) -> Target:
    """The boom's flow from its own pump."""
    high, end = machine.circuit("boom").pump.flow, travels(machine).end
    return Target(
        *place, lambda X: np.minimum(input_flow(machine, pump, X, ("boom",), "boom"), high),
        [(0.0, end), pressure_boxes(machine)["boom"]], {"boom.travel": borders("boom")}, high,
    )  # fmt: skip


def series_target(machine: LayoutMachine, pump: Pump, place: Place, borders: Borders) -> Target:
    """The flow of swing or stick, of everything in their circuit."""
    high, full = machine.circuit("series").pump.flow, (0.0, travels(machine).end)
    pressure, name = pressure_boxes(machine), place[0].name.split(".")[0]
    return Target(
        *place, lambda X: np.minimum(input_flow(machine, pump, X, SERIES, name), high),
        [full, full, pressure["swing"], pressure["stick"]], {f"{f}.travel": borders(f) for f in SERIES}, high,
    )  # fmt: skip


def learn_mode(target: Target, effort: Effort, progress: Progress = quiet) -> Model:
    """Learn a network with an effort."""
    bounds = (0.0, target.high)
    finer = None if effort.finer is None else clone(effort.finer).set_params(output_bounds=bounds)
    return learn_from(
        target.function, target.box, tolerance=effort.tolerance, edges=target.edges, budget=10_000_000,
        max_regions=effort.regions, rows=effort.rows, estimator=AbductiveRegressor(max_layers=3, output_bounds=bounds),
        finer=finer, finer_rows=effort.finer_rows, inputs=target.inputs, output=target.output, random_state=SEED,
        progress=lambda what, asked, most: progress(f"{target.output.name}: {what}", asked, most),
    ).model  # fmt: skip


def learn_k_in(machine: LayoutMachine, circuit: str, borders: Borders) -> Model:
    """Conductance of the inlet of a circuit's first valve, from the flow at relief pressure into an empty line (Eq. 1)."""
    name = machine.circuit(circuit).functions[0]
    pump, valve, end = at_relief(machine, circuit), machine.function(name).valve, travels(machine).end
    output, inputs = k_in(name)
    high, root = max(valve.inlet), np.sqrt(pump.relief)

    def conductance(X: np.ndarray) -> np.ndarray:
        return input_flow(machine, pump, np.column_stack([X, np.zeros(len(X))]), (name,), name) / root

    return learn_from(
        conductance, [(0.0, end)], tolerance=1e-5 * high, rows=300, edges={0: borders(name)},
        estimator=AbductiveRegressor(max_layers=1, kinds=("single",), output_bounds=(0.0, high)),
        inputs=inputs, output=output, random_state=SEED,
    ).model  # fmt: skip
