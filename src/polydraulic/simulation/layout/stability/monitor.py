"""Margins against tipping of any state of a machine: what a cockpit or a controller asks for while it moves."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.machine.stability.watched import BEHIND, SHOWN
from polydraulic.machine.stability.whole_body import chassis_of
from polydraulic.parameters.layout.chassis import edge_names
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.stability.columns import WARNED, row_margins


class Stability(NamedTuple):
    """How far a machine, or each of many, is from tipping.

    Attributes
    ----------
    distance, dynamic_distance : (..., n_edge) array, m
        To each edge, of the centre of gravity and with inertia and loads; at rest both are equal.
    force_angle : (..., n_edge) array, N m
    energy : (..., n_edge) array, J
    edge : (...) array of int
        The edge with the least dynamic distance.
    time_to_tip : (...) array, s
    warning : (...) array of bool
        Whether it tips, or is foreseen to within 2 s.
    gravity : (..., 2) array, m
        x and y of the place where the line of gravity through the common centre of gravity meets the ground.
    """

    distance: np.ndarray
    dynamic_distance: np.ndarray
    force_angle: np.ndarray
    energy: np.ndarray
    edge: np.ndarray
    time_to_tip: np.ndarray
    warning: np.ndarray
    gravity: np.ndarray


class StabilityMonitor:
    """Says how far a machine is from tipping, from a row of its state alone.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        With a chassis.
    dt : float, s
        Step of the simulation: accelerations are those of a step that begins at the row.
    locked : collection of str
        Functions whose joints are held.

    Attributes
    ----------
    edges : tuple of str
        Directions in which the machine can tip.

    Raises
    ------
    InputError
        A machine without a chassis, or that cannot be loaded.

    Examples
    --------
    >>> from polydraulic import Simulator, StabilityMonitor
    >>> loader = Simulator("wheel_loader")
    >>> monitor = StabilityMonitor("wheel_loader", dt=loader.dt)
    >>> loader.step({"lift": 0.5}, n=200)
    >>> seen = monitor(loader.state)
    >>> monitor.edges, bool(seen.warning)
    (('forward', 'left', 'rear', 'right'), False)
    """

    def __init__(self, machine: LayoutMachine | str | Path, *, dt: float = 5e-3, locked: tuple[str, ...] = ()) -> None:
        self._machine, self._dt, self._locked = as_machine(machine), dt, locked
        self.edges = edge_names(chassis_of(self._machine))
        self._columns = columns_of(self._machine)
        self._payload: float | None = None
        self._loaded(0.0)

    def _loaded(self, payload: float) -> None:
        if payload != self._payload:
            self._with = self._machine if payload == 0.0 else with_payload(self._machine, payload)
            self._ready = prepare_layout(self._with, self._dt, self._locked, force=True)
            self._payload = payload

    def _by_name(self, rows: Any) -> np.ndarray:
        """A state from columns."""
        return np.stack([np.asarray(rows[c.name]) for c in self._columns.columns[: self._columns.n_state]], axis=-1)

    def __call__(self, rows: Any, *, payload: float = 0.0, force: Any = (0.0, 0.0, 0.0)) -> Stability:
        """Margins of a row, or of many.

        Parameters
        ----------
        rows : (..., n_column) array, or anything that gives columns by their names
            States as `Simulator.state` or `Simulator.values` gives them: what stands behind the state is not read. Or a
            `Simulator`, `BatchSimulator`, `Batch` or run itself, or a mapping: of these the columns of the state are read by name.
        payload : float, kg
            At the tip. Another one than before takes some milliseconds to prepare.
        force : (..., 3) array, N
            At the tip, along the ground's axes.

        Raises
        ------
        InputError
            Rows of another length, or numbers that are not finite.
        """
        n = self._columns.n_state
        given = np.asarray(rows if isinstance(rows, np.ndarray | list | tuple) else self._by_name(rows), dtype=float)
        if given.ndim == 0 or given.shape[-1] < n:
            raise InputError(f"rows of the shape {given.shape}: the last axis must hold the {n} numbers of a state")
        lead = given.shape[:-1]
        state = given[..., :n].reshape(-1, n)
        push = np.ascontiguousarray(np.broadcast_to(np.asarray(force, dtype=float), (*lead, 3)).reshape(-1, 3))
        if not (np.isfinite(state).all() and np.isfinite(push).all() and np.isfinite(payload) and payload >= 0.0):
            raise InputError(
                "a state, force or payload is not finite, or the payload is negative: no margin can be given"
            )
        self._loaded(float(payload))
        whole = np.zeros((len(state), len(self._columns.columns)))
        whole[:, :n] = state
        found = row_margins(self._with, self._ready.module, self._ready.plant, whole, self._columns, push)
        found = found.reshape(*lead, -1)
        n_behind = len(BEHIND)
        measures = found[..., :-n_behind].reshape(*lead, len(SHOWN), -1)[..., :-1]  # without the least of each
        distance, dynamic, force_angle, energy = np.moveaxis(measures, -2, 0)
        edge, soon, gravity = found[..., -n_behind].astype(int), found[..., 1 - n_behind], found[..., 2 - n_behind :]
        return Stability(distance, dynamic, force_angle, energy, edge, soon, np.asarray(soon <= WARNED), gravity)
