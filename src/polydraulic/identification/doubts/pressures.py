"""Whether pressures push joints as their motion, weight and friction ask for.

The torque of the oil follows from both pressures and the actuator's levers, what a motion needs from positions and masses. By the file of a machine whose
masses are off by half the two still go together; with ports exchanged, or one of them in another unit, they do not, and the log says which of these it is:
the one with which they do.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.identification.doubts.joint_torques import torques_of_friction, torques_of_motion, weighted_sums
from polydraulic.identification.doubts.levers import Doubt
from polydraulic.identification.log_pieces import even_pieces
from polydraulic.identification.plausible import position_column
from polydraulic.machine.volumes import levers
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table
from polydraulic.watch.blocks import motion_filters

# of what is read: powers of ten, and psi for bar or bar for psi
_FACTORS = (0.01, 0.0689476, 0.1, 10.0, 14.5038, 100.0)
_MOST_ROWS = 60_000  # that are looked at
_FEW = 300  # rows away from stops that tell something
_SLOWEST = 0.1  # s between rows, at which accelerations are still seen
_NEAR_STOP = 0.02  # rad or m
# where pressures are put right, what is left of torques at most, of what was left; correlation of both torques at least, and how much more at least
_BETTER, _TOGETHER, _CLOSER = 0.35, 0.9, 0.03
_SCALE = 4.0  # by which the masses of a file are not off
_ABOVE, _RARE = 2.0, 1e-3  # times the highest relief setting, and share of rows beyond


class _Put(NamedTuple):
    """A way to put pressures right: ports exchanged, and what each reading is multiplied by."""

    exchanged: bool
    a: float
    b: float


class _Match(NamedTuple):
    """How the oil's torque goes with what is needed: correlation, slope, and share that is left."""

    together: float
    slope: float
    left: float

    @property
    def scaled(self) -> bool:
        """Whether the torque of the oil is of the size that is needed."""
        return 1.0 / _SCALE < self.slope < _SCALE

    def far_better(self, read: "_Match", put: _Put) -> bool:
        """Whether pressures that were put right move the machine of the file, and those that were read do not."""
        if not (self.left < _BETTER * read.left and self.together > _TOGETHER and self.scaled):
            return False
        return self.together > read.together + _CLOSER if put.a != put.b or put.exchanged else not read.scaled


_AS_READ = _Put(False, 1.0, 1.0)
_WAYS = [
    _Put(True, 1.0, 1.0),
    *(_Put(False, factor, factor) for factor in _FACTORS),
    *(_Put(False, factor, 1.0) for factor in _FACTORS),
    *(_Put(False, 1.0, factor) for factor in _FACTORS),
]


def pressure_doubts(machine: LayoutMachine, table: Table) -> Iterator[Doubt]:
    """Pressures that no valve of the file lets stand, or that push joints another way than they go."""
    high = False
    for f in machine.functions:
        most = max(f.line.relief, *(c.pump.relief for c in machine.circuits))
        beyond = tuple(p for p in _ports(f) if p in table.names and (table.columns[p] > _ABOVE * most).mean() > _RARE)
        if beyond:
            high, read = True, max(float(np.nanmax(table.columns[p])) for p in beyond)
            yield (
                beyond,
                f"{' and '.join(beyond)} read{'' if len(beyond) > 1 else 's'} up to {amount(read, 'Pa')}, and no relief valve of the file opens "
                f"above {amount(most, 'Pa')}: look at the unit where the log is imported",
            )
    needed = [
        "time",
        *(position_column(machine, f) for f in machine.functions),
        *(p for f in machine.functions for p in _ports(f)),
    ]
    if high or not set(needed) <= set(table.names) or not table.known(needed).any():
        return
    for f, ways in zip(machine.functions, _matches(machine, table), strict=True):
        own = ways.pop(_AS_READ, None)
        if own is None:
            continue
        put, best = min(ways.items(), key=lambda item: item[1].left)
        if best.far_better(own, put):
            yield _told(f, own, put)


def _told(f: MachineFunction, own: _Match, put: _Put) -> Doubt:
    a, b = _ports(f)
    begun = f"torques of the oil by {a} and {b} contradict what the motion of {f.name} needs (correlation {own.together:.2f}, slope {own.slope:.3g})"
    if put.exchanged:
        return (a, b), f"{begun} and fit it with the two exchanged: exchange them where the log is imported"
    wrong = tuple(column for column, factor in ((a, put.a), (b, put.b)) if factor != 1.0)
    factor = put.a if put.a != 1.0 else put.b
    return wrong, (
        f"{begun} and fit it with {' and '.join(wrong)} times {factor:.3g}: look at {'their' if len(wrong) > 1 else 'its'} unit where the log is imported"
    )


def _matches(machine: LayoutMachine, table: Table) -> Sequence[dict[_Put, _Match]]:
    """Of each function, how torques go together as they are read and with each way to put them right; empty where the log tells nothing."""
    columns = [position_column(machine, f) for f in machine.functions]
    columns += [_ports(f)[port] for port in (0, 1) for f in machine.functions]
    found: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in machine.functions]
    left = _MOST_ROWS
    for time, values in even_pieces(table, columns):
        raster = float(np.median(np.diff(time))) if len(time) > 1 else np.inf
        if left <= 0 or raster > _SLOWEST:
            continue
        smooth, slope, curve = motion_filters(raster)
        if len(time) < 2 * len(smooth):
            continue
        position, p_a, p_b = np.split(values[:left], 3, axis=1)
        left -= len(time)
        q, qd, qdd = (weighted_sums(position, weights) for weights in (smooth, slope, curve))
        wanted = torques_of_motion(machine, q, qd, qdd) + torques_of_friction(machine, qd)[0]
        for k, f in enumerate(machine.functions):
            away = (q[:, k] > f.stops.low + _NEAR_STOP) & (q[:, k] < f.stops.high - _NEAR_STOP)
            arm_a, arm_b = levers(machine, f, q[:, k])
            a, b = (weighted_sums(p[:, k], smooth) for p in (p_a, p_b))
            found[k].append((np.array([arm_a * a, arm_b * b, arm_a * b, arm_b * a])[:, away], wanted[away, k]))
    return [_ways([part[0] for part in of], [part[1] for part in of]) for of in found]


def _ways(pushes: list[np.ndarray], wanted: list[np.ndarray]) -> dict[_Put, _Match]:
    if sum(map(len, wanted)) < _FEW:
        return {}
    (own_a, own_b, other_a, other_b), need = np.concatenate(pushes, axis=1), np.concatenate(wanted)
    whole = float(np.median(np.abs(need)))
    if not (whole > 0.0 and np.std(need) > 0.0):
        return {}
    found = {}
    for put in (_AS_READ, *_WAYS):
        oil = other_a - other_b if put.exchanged else put.a * own_a - put.b * own_b
        if np.std(oil) > 0.0:
            together = float(np.corrcoef(oil, need)[0, 1])
            found[put] = _Match(
                together, float(oil @ need / (need @ need)), float(np.median(np.abs(oil - need))) / whole
            )
    return found


def _ports(f: MachineFunction) -> tuple[str, str]:
    return f"{f.name}.p_a", f"{f.name}.p_b"
