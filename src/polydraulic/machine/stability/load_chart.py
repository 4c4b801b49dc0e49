"""Lift charts: what a machine can lift over reach and height, over its front and over its side, and what limits it where."""

from collections.abc import Mapping
from math import ceil, floor, log10, pi
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.machine.reach.tip import slewing_function, tip_at_joints
from polydraulic.machine.stability.lifting import lift_limits
from polydraulic.machine.stability.poses import arm_functions, arm_poses, held_positions
from polydraulic.machine.stability.whole_body import chassis_of
from polydraulic.parameters.layout.chassis import edge_names
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

MOST_CELLS = 250_000
_COLUMNS = 9  # about, of a chart whose step is not given
NOWHERE = -1


class LoadChart(NamedTuple):
    """Lift capacity over reach and height.

    Attributes
    ----------
    title : str
        Of the machine.
    reach : (n_reach,) array, m
        Horizontally from the slewing axis (of a machine that does not slew, from the origin of its ground frame).
    height : (n_height,) array, m
        Above the ground, rising.
    over : tuple of str
        ``front`` and ``side``; of a machine that does not slew the first alone.
    capacity : (n_over, n_height, n_reach) array, kg
        nan where the tip cannot be, and where nothing limits the load.
    limit : (n_over, n_height, n_reach) array of int
        Place in `limits`, -1 where there is no capacity.
    limits : tuple of str
        What can limit: ``tipping forward``, ..., ``boom``, ...
    tipping : int
        How many of `limits` are tipping.
    positions : (n_over, n_height, n_reach, n_function) array, rad or m
        Of the pose, where there is a capacity.
    moved, lifting : tuple of str, str
        The functions that bring the tip to its places, and the one that lifts at working pressure.
    """

    title: str
    reach: np.ndarray
    height: np.ndarray
    over: tuple[str, ...]
    capacity: np.ndarray
    limit: np.ndarray
    limits: tuple[str, ...]
    tipping: int
    positions: np.ndarray
    moved: tuple[str, str]
    lifting: str

    @property
    def table(self) -> Table:
        """Cells with a capacity, a row each: ``reach``, ``height``, ``side`` (0 over the front), ``capacity``, ``limit``; `info` names the limits."""
        at = np.argwhere(np.isfinite(self.capacity))
        over, row, column = at.T
        values = {
            "reach": self.reach[column],
            "height": self.height[row],
            "side": over.astype(float),
            "capacity": self.capacity[over, row, column],
            "limit": self.limit[over, row, column].astype(float),
        }
        units = {"reach": "m", "height": "m", "side": "1", "capacity": "kg", "limit": "1"}
        return Table(values, units, {"over": list(self.over), "limits": list(self.limits), "moved": list(self.moved)})


def load_chart(
    machine: LayoutMachine | str | Path,
    *,
    step: float | None = None,
    moved: tuple[str, str] | None = None,
    lifting: str | None = None,
    held: Mapping[str, float] | None = None,
    progress: Progress = quiet,
) -> LoadChart:
    """Lift chart of a machine on level ground, by the rule of ISO 10567: the lower of 75 % of tipping and 87 % of hydraulic capacity.

    The load hangs at the tip as a point mass; what is at the end of the arm (bucket, grapple) counts as part of the machine.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        With a chassis.
    step : float, m, optional
        Between reaches and heights; without, such that there are about nine reaches.
    moved : (str, str), optional
        Two functions that bring the tip to its places; the first two that turn it in the plane of the arm if not given.
    lifting : str, optional
        Of all functions the one that lifts at the pump's pressure, while the others hold; the first of `moved` if not given.
    held : mapping from function to position, rad or m, optional
        Of the others, where they are not at their initial positions.
    progress : Progress, optional

    Returns
    -------
    LoadChart
        Of two poses with the tip at a place, that with the larger capacity.

    Raises
    ------
    InputError
        A machine without a chassis, functions that cannot move the tip so, positions beyond stops, a step that is not positive or too fine.

    Examples
    --------
    >>> from polydraulic import load_chart
    >>> chart = load_chart("wheel_loader", step=0.5)
    >>> chart.over, chart.moved
    (('front',), ('lift', 'tilt'))
    """
    machine = as_machine(machine)
    edges = edge_names(chassis_of(machine))
    pair = arm_functions(machine, moved)
    lifts = pair[0].name if lifting is None else lifting
    if lifts not in machine.names:
        raise InputError(f"{lifts!r} is not a function of the machine; there are {list(machine.names)}")
    base = held_positions(machine, held or {})
    taken = [f.name for f in pair if f.name in (held or {})]
    if taken:
        raise InputError(
            f"{taken[0]}: moves the tip from place to place, and cannot be held; choose other functions to move it"
        )
    ground = float(np.mean([z for _, _, z in machine.chassis.corners]))  # type: ignore[union-attr]
    slews = slewing_function(machine)
    if slews is not None and lifts == slews.name:
        raise InputError(f"{lifts}: turns the machine and lifts nothing; choose another function to lift")
    axis = machine.link(slews.moves).at.get("x", 0.0) if slews is not None else 0.0
    reach, height = _grid(machine, pair, base, axis, ground, step)
    across, up = np.meshgrid(reach + axis, height + ground)
    poses = arm_poses(machine, pair, base, np.column_stack([across.ravel(), up.ravel()]))
    turns = {"front": (0.0,)} if slews is None else {"front": (0.0,), "side": (-0.5 * pi, 0.5 * pi)}
    shape = (len(turns), len(height), len(reach))
    capacity, limit = np.full(shape, np.nan), np.full(shape, NOWHERE)
    positions = np.zeros((*shape, len(machine.names)))
    for k, (over, angles) in enumerate(turns.items()):
        progress(f"over the {over}", k, len(turns))
        able = [a for a in angles if slews is None or slews.stops.low <= a <= slews.stops.high]
        if not able:
            raise InputError(f"functions.{slews.name}.stops: the arm cannot be turned over the {over}")  # type: ignore[union-attr]
        best = _best(machine, poses.positions, poses.possible, able, slews, lifts)
        capacity[k], limit[k], positions[k] = (a.reshape(*shape[1:], *a.shape[1:]) for a in best)
    progress("done", len(turns), len(turns))
    if not np.isfinite(capacity).any():
        raise InputError(
            f"{machine.title}: the tip gets to no place of the chart where something limits the load; give a smaller step than {reach[0]:g} m, other "
            "functions to move, or other positions to hold"
        )
    names = (*(f"tipping {edge}" for edge in edges), *machine.names)
    moved_names = (pair[0].name, pair[1].name)
    return LoadChart(
        machine.title, reach, height, tuple(turns), capacity, limit, names, len(edges), positions, moved_names, lifts
    )


def _best(
    machine: LayoutMachine,
    positions: np.ndarray,
    possible: np.ndarray,
    angles: list[float],
    slews: object,
    lifting: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Capacity, limit and pose of each place: the better of both poses, over the worse of all directions."""
    n_edge = len(machine.chassis.corners)  # type: ignore[union-attr]
    found = np.full(len(positions[0]), np.nan)
    limit, poses = np.full(len(found), NOWHERE), positions[0].copy()
    for pose, able in zip(positions, possible, strict=True):
        rows = np.flatnonzero(able)
        least, by, at = np.full(len(rows), np.inf), np.full(len(rows), NOWHERE), pose[rows].copy()
        for angle in angles:
            turned = pose[rows].copy()
            if slews is not None:
                turned[:, 0] = angle
            of = lift_limits(machine, turned, lifting)
            lower = of.capacity < least
            least = np.where(lower, of.capacity, least)
            by = np.where(lower, np.where(of.by_tipping, of.edge, n_edge + of.function), by)
            at = np.where(lower[:, None], turned, at)
        better = np.isfinite(least) & ~(found[rows] >= least)
        found[rows[better]], limit[rows[better]], poses[rows[better]] = least[better], by[better], at[better]
    return found, limit, poses


def _grid(
    machine: LayoutMachine, pair: tuple, base: np.ndarray, axis: float, ground: float, step: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Reaches and heights where the tip can be, m."""
    low, high = (np.linspace(f.stops.low, f.stops.high, 41) for f in pair)
    poses = np.tile(base, (41 * 41, 1))
    if slewing_function(machine) is not None:
        poses[:, 0] = 0.0
    places = [machine.names.index(f.name) for f in pair]
    poses[:, places] = np.array([(a, b) for a in low for b in high])
    tips = tip_at_joints(machine, poses)
    most = float(tips[:, 0].max()) - axis
    bottom, top = float(tips[:, 2].min()) - ground, float(tips[:, 2].max()) - ground
    if most <= 0.0:
        raise InputError(f"{machine.title}: its tip is nowhere in front of the slewing axis")
    if step is None:
        rough = most / _COLUMNS
        scale = 10.0 ** floor(log10(rough))
        step = min((scale * n for n in (1.0, 2.0, 2.5, 5.0, 10.0)), key=lambda size: abs(log10(size / rough)))
    if not step > 0.0 or (most / step + 1.0) * ((top - bottom) / step + 1.0) > MOST_CELLS:
        raise InputError(f"step = {step:g} m: must be positive, and leave at most {MOST_CELLS} places")
    reach = step * np.arange(1, max(ceil(most / step - 1e-9), 1) + 1)
    return reach, step * np.arange(floor(bottom / step), ceil(top / step) + 1)
