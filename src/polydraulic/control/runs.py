"""Closed loops: a machine that is moved by a controller along a path, with sensors that are late and noisy."""

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from polydraulic.control.arm import arm_pose, planar_arm
from polydraulic.control.coordinated import measured_columns
from polydraulic.control.planning import check_path
from polydraulic.control.references import TipPath
from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.stepping.simulator import Simulator
from polydraulic.tables import Table

_STUCK, _PATIENCE = 1e-3, 3.0  # a share of the wanted velocity that is none, and s for which it may last
_TOWARDS = 2.0  # 1/s: how fast a reference that has left its path comes back


class Controller(Protocol):
    """What moves a machine in `run_controlled`: `CoordinatedControl`, or anything that has its period, calls and reference."""

    dt: float
    lag: float
    reference: np.ndarray
    share: Any

    def reset(self) -> None:
        """Begin anew."""

    def step(self, measured: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Voltages of the levers; `measured` holds positions, then pressures at A and B, `wanted` reach, height, swing and pitch rates."""


class SensorErrors(NamedTuple):
    """Of positions and pressures that a controller gets.

    Attributes
    ----------
    angle : float, rad or m
        Standard deviation of white noise of positions.
    pressure : float, Pa
    delay : float, s
        By which they are late.
    seed : int
    """

    angle: float = 0.0
    pressure: float = 0.0
    delay: float = 0.0
    seed: int = 0


FAULTLESS = SensorErrors()


def run_controlled(
    machine: LayoutMachine | str | Path,
    controller: Controller,
    path: Callable[[np.ndarray], TipPath],
    *,
    flow: str | FlowModel = "exact",
    errors: SensorErrors = FAULTLESS,
    start: Mapping[str, float] | None = None,
    settle: float = 2.0,
    limit: float = 120.0,
    dt: float = 5e-3,
) -> Table:
    """A machine along a path, moved by a controller.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        That is moved; the controller may know another one.
    controller : Controller
    path : function of a (4,) array
        From where the tip is (reach, height, swing, pitch) when the controller begins, to a path: ``lambda tip: straight_line(tip, length=4)``.
    flow : str or flow model
        Of the machine that is moved.
    errors : SensorErrors
    start : mapping from column to value, optional
        As for `Simulator.reset`.
    settle : float, s
        Before the controller begins, with levers at neutral.
    limit : float, s
        The end if the path takes longer, because the motion waits for oil; one that stands still ends after three seconds.
    dt : float, s
        Time step of the simulation; the controller's period is a multiple.

    Returns
    -------
    Table
        A row for each call of the controller: ``time``, ``tip.*`` and ``target.*`` (reach, height, swing, pitch), ``share``, and positions,
        pressures and voltages of all functions; the target is that of the controller's lag ago, where the tip should be now.

    Warns
    -----
    UserWarning
        Where the path was not finished.

    Raises
    ------
    InputError
        A controller whose period is no multiple of the time step, a path that the machine cannot follow between its stops (`check_path`), or
        what `Simulator` refuses.
    """
    every = round(controller.dt / dt)
    if every < 1 or abs(every * dt - controller.dt) > 1e-9:
        raise InputError(f"dt = {dt:g} s: the controller's period, {controller.dt:g} s, must be a whole multiple of it")
    found = as_machine(machine)
    rng, rows = np.random.default_rng(errors.seed), []
    late = round(errors.delay / controller.dt)
    with Simulator(found, flow, dt=dt) as moved:
        moved.reset(start)
        moved.step(np.zeros(len(found.names)), n=max(round(settle / dt), 1))
        seen = [moved.place[column] for column in measured_columns(found)]
        spread = np.repeat([errors.angle, errors.pressure, errors.pressure], len(found.names))
        tip_of = _tip(found)
        reference = path(tip_of(moved.values[seen]))
        check_path(found, reference, moved.values[seen[: len(found.names)]])
        controller.reset()
        clock, stuck, before = 0.0, 0.0, reference.points[0]
        waiting = [moved.values[seen] + spread * rng.standard_normal(len(seen)) for _ in range(late + 1)]
        recent = [reference.points[0]] * (round(controller.lag / controller.dt) + 1)
        for _ in range(round(limit / controller.dt)):
            waiting = [*waiting[1:], moved.values[seen] + spread * rng.standard_normal(len(seen))]
            point, velocity = reference.at(clock)
            back = before - controller.reference if clock > 0.0 else np.zeros(4)
            volts = controller.step(waiting[0], velocity + _TOWARDS * back)
            recent, before = [*recent[1:], point], point
            rows.append(
                [
                    moved.time,
                    *tip_of(moved.values[seen]),
                    *recent[0],
                    float(controller.share),
                    *moved.values[seen],
                    *volts,
                ]
            )
            moved.step(volts, n=every)
            clock += controller.dt * (float(controller.share) if clock > 0.0 else 1.0)
            stuck = 0.0 if float(controller.share) > _STUCK else stuck + controller.dt
            if clock > reference.duration + 1.0 or stuck > _PATIENCE:
                break
    if clock < reference.duration:
        why = "stood still" if stuck > _PATIENCE else f"was not through when the limit of {limit:g} s came"
        warnings.warn(
            f"{found.title}: the tip {why}, {100.0 * clock / reference.duration:.0f} % of its path behind it; the rest is not in the table",
            stacklevel=2,
        )
    return _table(found, np.array(rows))


def _tip(machine: LayoutMachine) -> Callable[[np.ndarray], np.ndarray]:
    """From positions of the joints to reach, height, swing and pitch."""
    arm, n = planar_arm(machine), len(machine.names)
    scratch = np.zeros(3 * n)

    def tip(values: np.ndarray) -> np.ndarray:
        scratch[:n] = values[:n]
        pose = arm_pose(arm, scratch, 0, n)
        return np.array([pose.reach, pose.height, values[arm.swing] if arm.swing >= 0 else 0.0, pose.pitch])

    return tip


def _table(machine: LayoutMachine, rows: np.ndarray) -> Table:
    coordinates = {"reach": "m", "height": "m", "swing": "rad", "pitch": "rad"}
    units = {"time": "s"}
    units |= {f"{of}.{what}": unit for of in ("tip", "target") for what, unit in coordinates.items()}
    units |= {"share": "1"}
    endings = {"angle": "rad", "position": "m", "p_a": "Pa", "p_b": "Pa"}
    units |= {column: endings[column.rpartition(".")[2]] for column in measured_columns(machine)}
    units |= {f"{name}.voltage": "V" for name in machine.names}
    return Table(dict(zip(units, rows.T, strict=True)), units)
