"""What is said of a machine that moves: margins over all edges, the least of them, and how soon it tips, as one row of numbers.

A row holds `distance` over each edge and the least of them, then `dynamic_distance`, `force_angle` and `energy` in the same way, then the number of
the edge with the least dynamic distance, the time to a tip, and x and y of the place where the line of gravity through the common centre of
gravity meets the ground.
"""

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.machine.stability.body import N_LINK, Body, edge_of, point_of, stand
from polydraulic.machine.stability.vectors import Vector
from polydraulic.parameters.layout.schema import LayoutMachine

SHOWN = (("distance", "m"), ("dynamic_distance", "m"), ("force_angle", "N m"), ("energy", "J"))
BEHIND = (("edge", "1"), ("time_to_tip", "s"), ("gravity_x", "m"), ("gravity_y", "m"))
FORESEEN = 60.0  # s: no tip is foreseen further ahead
SAME_RATE = 1e-9  # share: rates that a stop holds


def n_watched(n_edge: int) -> int:
    """Numbers of a row."""
    return len(SHOWN) * (n_edge + 1) + len(BEHIND)


@kernel
def calm_blows(n: int, dt: float, live: np.ndarray, motion: int) -> None:
    """Let accelerations be zero where a joint meets an end stop: its blow lasts a step, and a machine does not tip in one.

    Positions, rates, accelerations, lower and upper stops of all `n` joints stand in `live` from `motion` on; accelerations are those of a step of `dt` that
    begins there.
    """
    blow = False
    for j in range(n):
        rate, gained = live[motion + n + j], live[motion + 2 * n + j]
        after = live[motion + j] + dt * rate
        held = abs(rate + dt * gained) <= SAME_RATE * abs(rate) and rate != 0.0
        blow = blow or (held and (after >= live[motion + 4 * n + j] or after <= live[motion + 3 * n + j]))
    for j in range(n):
        live[motion + 2 * n + j] = 0.0 if blow else live[motion + 2 * n + j]


@kernel
def watch(
    body: Body,
    live: np.ndarray,
    motion: int,
    links: int,
    push: Vector,
    pitch: float,
    roll: float,
    row: np.ndarray,
    place: int,
) -> None:
    """Write the numbers of a machine into a row from `place` on; arguments as of `polydraulic.machine.stability.body.stand`.

    The time to a tip is the lesser of static and dynamic distance over the speed at which the static one closes, least over the edges; 0 where it tips.
    """
    n_edge = body.n_edge
    wide = n_edge + 1
    s = stand(body, live, motion, links, push, pitch, roll)
    soonest, critical, least = FORESEEN, 0, 0.0
    for k in range(n_edge):
        m = edge_of(body, k, s)
        row[place + k] = m.distance
        row[place + wide + k] = m.dynamic_distance
        row[place + 2 * wide + k] = m.force_angle
        row[place + 3 * wide + k] = m.energy
        left = min(m.distance, m.dynamic_distance)
        soon = left / m.closing if m.closing > 1e-9 else FORESEEN
        soonest = min(soonest, 0.0 if left <= 0.0 else soon)
        critical = k if k == 0 or m.dynamic_distance < least else critical
        least = m.dynamic_distance if k == 0 or m.dynamic_distance < least else least
    for measure in range(4):
        first = place + measure * wide
        smallest = row[first]
        for k in range(1, n_edge):
            smallest = min(smallest, row[first + k])
        row[first + n_edge] = smallest
    row[place + 4 * wide] = float(critical)
    row[place + 4 * wide + 1] = soonest
    fall = (s.cg.z - body.corners[2]) / s.upward.z
    row[place + 4 * wide + 2] = s.cg.x - fall * s.upward.x
    row[place + 4 * wide + 3] = s.cg.y - fall * s.upward.y


def watched_room(machine: LayoutMachine) -> np.ndarray:
    """What `watch_all` reads and writes: room for motions, stops, room for links."""
    n = len(machine.names)
    low, high = ([float(getattr(f.stops, end)) for f in machine.functions] for end in ("low", "high"))
    return np.array([*[0.0] * (3 * n), *low, *high, *[0.0] * (N_LINK * (n + 1))])


@driver
def watch_all(
    body: Body, dt: float, live: np.ndarray, motions: np.ndarray, forces: np.ndarray, rows: np.ndarray
) -> None:
    """Rows of `watch` of many states.

    Parameters
    ----------
    body : Body
    dt : float, s
        Of the steps whose accelerations these are.
    live : array
        As `watched_room` gives it.
    motions : (n_row, 3 n_function) array
        Positions, rates, accelerations.
    forces : (n_row, 3) array, N
    rows : (n_row, n_watched) array
        Written.
    """
    size = motions.shape[1]
    for k in range(motions.shape[0]):
        for j in range(size):
            live[j] = motions[k, j]
        calm_blows(body.parent.shape[0], dt, live, 0)
        push = point_of(forces[k], 0)
        watch(body, live, 0, 5 * body.parent.shape[0], push, body.pitch, body.roll, rows[k], 0)
