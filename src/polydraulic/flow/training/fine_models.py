"""The finer networks of cat215b: parted at every knot of the orifice tables, and with more regions.

A flow has a kink wherever an orifice table has a knot. Regions that are found have to be cut there first, many times over where four inputs decide, as the
search does not know that a kink goes straight through all of them; regions that begin there have smooth flows from the start.
"""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.slots import inlet_shut
from polydraulic.flow.training.circuit_models import (
    BOOM_IN,
    SERIES,
    Borders,
    Target,
    input_flow,
    learn_outlets,
)
from polydraulic.flow.training.mode_models import (
    FINE,
    SWING_IN,
    Effort,
    at_constant_flow,
    boom_target,
    learn_k_in,
    learn_mode,
    series_target,
    stick_targets,
)
from polydraulic.machine.pump import NEVER
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.partition import Partition, Split, checked_edges, grid, region_boxes
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

_HALVINGS = 60  # of the range of a flow: more than its digits
OF_TWO = Effort(0.2 * FINE, 64, 1500)
OF_THREE = Effort(FINE, 96, 1500, AbductiveRegressor(max_layers=4, carve=False), 2000)
OF_CELL = Effort(FINE, 10, 1500, AbductiveRegressor(max_layers=5, carve=False), 2500)


def knots_of(machine: LayoutMachine) -> Borders:
    """Every knot of a valve's tables inside the range of its spool."""
    return lambda name: list(machine.function(name).valve.knots[1:-1])


def check_valve_open(machine: LayoutMachine, X: np.ndarray) -> np.ndarray:
    """Flow into the swing at constant pump flow if the stick's check valve were open, m3/s; of travels and pressures (n_point, 4).

    Where the valve is shut in truth, the stick's line then feeds what passes the swing's valve, as if without resistance, and the flow goes
    on from the border without a kink, and is more than the true one. So the true flow is the least of this and of that with the valve shut.
    """
    flow, (valve, stick) = machine.circuit("series").pump.flow, (machine.function(name).valve for name in SERIES)
    sample = sample_valves([valve, stick], at_constant_flow(machine, "series"), X[:, :2], X[:, 2:])
    k_in, k_bypass = (np.interp(X[:, 0], valve.knots, curve) for curve in (valve.inlet, valve.bypass))
    low, high = np.zeros(len(X)), np.where(k_in > 0.0, flow, 0.0)
    for _ in range(_HALVINGS):
        q = 0.5 * (low + high)
        # of inlet and bypass, P_pump = p_swing + (q / k_in)^2 and p_stick + ((flow - q) / k_bypass)^2
        inlet = k_bypass**2 * (k_in**2 * X[:, 2] + q**2)
        bypass = k_in**2 * (k_bypass**2 * X[:, 3] + (flow - q) ** 2)
        low, high = np.where(inlet < bypass, q, low), np.where(inlet < bypass, high, q)
    fed = (sample.q_in[:, 1] > 0.0) | (X[:, 1] <= spool_edges(stick)[0])
    return np.minimum(np.where(fed, sample.q_in[:, 0], np.maximum(low, sample.q_in[:, 0])), flow)


def check_valve_shut(machine: LayoutMachine, X: np.ndarray) -> np.ndarray:
    """The same with the stick's check valve shut; the pump's flow where the stick's inlet is, so that it is not the least there."""
    flow, opens = machine.circuit("series").pump.flow, spool_edges(machine.function("stick").valve)[0]
    shut = np.column_stack([X[:, :3], np.full(len(X), NEVER)])
    found = input_flow(machine, at_constant_flow(machine, "series"), shut, SERIES, "swing")
    return np.where(X[:, 1] <= opens, flow, np.minimum(found, flow))


def learn_fine(machine: LayoutMachine, progress: Progress = quiet) -> list[Model]:
    """Networks of all flows at constant pump flow and at relief, and of all outlets.

    Parameters
    ----------
    machine : LayoutMachine
    progress : Progress, optional
        Told the output and its largest error so far in m3/s, and how many points have been asked.
    """
    borders = knots_of(machine)
    boom = boom_target(machine, at_constant_flow(machine, "boom"), BOOM_IN, borders)
    efforts = [(boom, OF_TWO), *((target, OF_THREE) for target in stick_targets(machine, borders))]
    return [
        *learn_outlets(machine, borders),
        *(learn_k_in(machine, circuit, borders) for circuit in ("boom", "series")),
        *(learn_mode(target, effort, progress) for target, effort in efforts),
        *(
            joined_cells(target, [learn_mode(cell, OF_CELL, progress) for cell in cells_of(target)])
            for target in swing_targets(machine)
        ),
    ]


def swing_targets(machine: LayoutMachine) -> list[Target]:
    """The swing's flow with the stick's check valve open, and shut."""
    pump, series = at_constant_flow(machine, "series"), machine.circuit("series")
    return [
        series_target(machine, pump, place, knots_of(machine))._replace(function=partial(flow, machine))
        for place, flow in ((SWING_IN, check_valve_open), (inlet_shut(series, "swing"), check_valve_shut))
    ]


def cells_of(target: Target) -> list[Target]:
    """A target by the cells that its borders make, in the order of `joined_cells`; a border belongs to the cell below it."""
    names = [variable.name for variable in target.inputs]
    low, high = np.array(target.box).T
    cells = region_boxes(grid(checked_edges(target.edges, names)), len(names))
    return [
        target._replace(
            box=list(
                zip(
                    np.maximum(np.nextafter(cells[k][:, 0], np.inf), low), np.minimum(cells[k][:, 1], high), strict=True
                )
            ),
            edges={},
        )
        for k in sorted(cells)
    ]


def joined_cells(target: Target, models: list[Model]) -> Model:
    """One model of those that have learnt the cells of a target."""
    names = [variable.name for variable in target.inputs]
    starts = np.cumsum([0, *(len(model.networks) for model in models)])

    def moved(partition: Partition, by: int) -> Partition:
        if isinstance(partition, Split):
            return replace(partition, below=moved(partition.below, by), above=moved(partition.above, by))
        return partition + by

    def filled(partition: Partition) -> Partition:
        if isinstance(partition, Split):
            return replace(partition, below=filled(partition.below), above=filled(partition.above))
        return moved(models[partition].partition, int(starts[partition]))

    found: list[dict[str, Any]] = [model.training for model in models]
    worst = max(found, key=lambda training: float(training["largest_error"]))
    asked = sum(int(training["n_evaluations"]) for training in found)
    return replace(
        models[0],
        networks=tuple(network for model in models for network in model.networks),
        partition=filled(grid(checked_edges(target.edges, names))),
        training=worst | {"n_evaluations": asked},
    )
