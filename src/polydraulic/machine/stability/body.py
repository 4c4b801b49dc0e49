"""A machine as one body, as kernels: weight, centre of gravity and its velocity, and the force and moment that the ground must bear.

Newton and Euler from the ground outward, link after link. A simulated run, a monitor, a controller and exported C ask the same kernels, so that
all of them see the same bits. They read and write one array of numbers: motions of the joints, and behind them `N_LINK` numbers of each link.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.machine.stability.margins import EdgeMargins, Standing, edge_margins
from polydraulic.machine.stability.vectors import Vector, cross_product, plus, times

N_LINK = 24  # of a link: turn row by row, then place, spin, twist, acceleration and velocity of its joint
PLACE, SPIN, TWIST, GAINED, SPEED = 9, 12, 15, 18, 21  # where these begin


class Body(NamedTuple):
    """Numbers of a machine on its ground; arrays have an entry, or one for each coordinate, for each link in kinematic order.

    Attributes
    ----------
    parent : array of int
        Number of the link before it, -1 of the ground.
    slides, axis : array of int
        1 of a prismatic joint; 0 to 2 for an axis along x, y or z.
    sign : array
        -1 where a positive position is against the axis.
    at, cg : array, m
        The joint in the frame of the link before it; centre of gravity.
    mass : array, kg
    inertia : array, kg m2
        About the centre of gravity: xx, yy, zz, xy, xz, yz of each link.
    tip_link : int
    tip, still : array, m
        The tip in its link's frame; centre of gravity of all that no joint moves.
    still_mass : float, kg
    gravity : float, m/s2
    pitch, roll : float, rad
        How the ground rises.
    n_edge : int
    corners : array, m
        Of the contact polygon, x, y and z of each, counter-clockwise from the most forward edge on.
    """

    parent: np.ndarray
    slides: np.ndarray
    axis: np.ndarray
    sign: np.ndarray
    at: np.ndarray
    cg: np.ndarray
    mass: np.ndarray
    inertia: np.ndarray
    tip_link: int
    tip: np.ndarray
    still: np.ndarray
    still_mass: float
    gravity: float
    pitch: float
    roll: float
    n_edge: int
    corners: np.ndarray


@kernel
def point_of(values: np.ndarray, place: int) -> Vector:
    """Three numbers of an array."""
    return Vector(values[place], values[place + 1], values[place + 2])


@kernel
def put(values: np.ndarray, place: int, x: float, y: float, z: float) -> None:
    """Write three numbers into an array."""
    values[place] = x
    values[place + 1] = y
    values[place + 2] = z


@kernel
def turned(live: np.ndarray, link: int, v: Vector) -> Vector:
    """A vector of a link's frame along the axes of the ground."""
    return Vector(
        live[link] * v.x + live[link + 1] * v.y + live[link + 2] * v.z,
        live[link + 3] * v.x + live[link + 4] * v.y + live[link + 5] * v.z,
        live[link + 6] * v.x + live[link + 7] * v.y + live[link + 8] * v.z,
    )


@kernel
def turned_back(live: np.ndarray, link: int, v: Vector) -> Vector:
    """A vector along the axes of the ground in a link's frame."""
    return Vector(
        live[link] * v.x + live[link + 3] * v.y + live[link + 6] * v.z,
        live[link + 1] * v.x + live[link + 4] * v.y + live[link + 7] * v.z,
        live[link + 2] * v.x + live[link + 5] * v.y + live[link + 8] * v.z,
    )


@kernel
def carried(spin: Vector, twist: Vector, arm: Vector) -> Vector:
    """Acceleration of a point of a body that turns, from that of another one of it."""
    along = cross_product(twist, arm)
    whirl = cross_product(spin, arm)
    inward = cross_product(spin, whirl)
    return plus(along, inward)


@kernel
def upward_on(pitch: float, roll: float) -> Vector:
    """Against gravity, where the ground rises so."""
    ahead = sincos(pitch)
    aside = sincos(roll)
    x, y = ahead.sin / ahead.cos, aside.sin / aside.cos
    scale = 1.0 / sqrt(x * x + y * y + 1.0)
    return Vector(scale * x, scale * y, scale)


@kernel
def move_link(body: Body, live: np.ndarray, motion: int, links: int, i: int) -> None:
    """Where a link is and how its joint moves, from the link before it."""
    n = body.parent.shape[0]
    before, own = links + N_LINK * (body.parent[i] + 1), links + N_LINK * (i + 1)
    slides, a = body.slides[i] == 1, body.axis[i]
    b = a + 1 if a < 2 else 0
    c = a - 1 if a > 0 else 2
    q = body.sign[i] * live[motion + i]
    slid = q if slides else 0.0
    turn = sincos(0.0 if slides else q)
    for k in range(3):
        first, second = live[before + 3 * k + b], live[before + 3 * k + c]
        live[own + 3 * k + a] = live[before + 3 * k + a]
        live[own + 3 * k + b] = turn.cos * first + turn.sin * second
        live[own + 3 * k + c] = turn.cos * second - turn.sin * first
    given = point_of(body.at, 3 * i)
    at = Vector(
        given.x + (slid if a == 0 else 0.0), given.y + (slid if a == 1 else 0.0), given.z + (slid if a == 2 else 0.0)
    )
    arm = turned(live, before, at)
    sign = body.sign[i]
    axis = Vector(sign * live[before + a], sign * live[before + 3 + a], sign * live[before + 6 + a])
    spin = point_of(live, before + SPIN)
    twist = point_of(live, before + TWIST)
    along = times(live[motion + n + i], axis)  # rate
    grown = times(live[motion + 2 * n + i], axis)  # acceleration
    whirl = cross_product(spin, along)
    hung = carried(spin, twist, arm)
    swept = cross_product(spin, arm)
    s, t = 1.0 if slides else 0.0, 0.0 if slides else 1.0
    put(
        live,
        own + PLACE,
        live[before + PLACE] + arm.x,
        live[before + PLACE + 1] + arm.y,
        live[before + PLACE + 2] + arm.z,
    )
    put(live, own + SPIN, spin.x + t * along.x, spin.y + t * along.y, spin.z + t * along.z)
    put(
        live, own + TWIST,
        twist.x + t * (grown.x + whirl.x), twist.y + t * (grown.y + whirl.y), twist.z + t * (grown.z + whirl.z),
    )  # fmt: skip
    put(
        live, own + GAINED,
        live[before + GAINED] + hung.x + s * (grown.x + 2.0 * whirl.x),
        live[before + GAINED + 1] + hung.y + s * (grown.y + 2.0 * whirl.y),
        live[before + GAINED + 2] + hung.z + s * (grown.z + 2.0 * whirl.z),
    )  # fmt: skip
    put(
        live, own + SPEED,
        live[before + SPEED] + swept.x + s * along.x,
        live[before + SPEED + 1] + swept.y + s * along.y,
        live[before + SPEED + 2] + swept.z + s * along.z,
    )  # fmt: skip


@kernel
def spun(body: Body, live: np.ndarray, link: int, i: int, v: Vector) -> Vector:
    """Inertia of a link times a vector along the axes of the ground."""
    own = turned_back(live, link, v)
    k = 6 * i
    made = Vector(
        body.inertia[k] * own.x + body.inertia[k + 3] * own.y + body.inertia[k + 4] * own.z,
        body.inertia[k + 3] * own.x + body.inertia[k + 1] * own.y + body.inertia[k + 5] * own.z,
        body.inertia[k + 4] * own.x + body.inertia[k + 5] * own.y + body.inertia[k + 2] * own.z,
    )
    return turned(live, link, made)


@kernel
def stand(body: Body, live: np.ndarray, motion: int, links: int, push: Vector, pitch: float, roll: float) -> Standing:
    """The machine as one body.

    Parameters
    ----------
    body : Body
    live : array
        Holds positions, rates and accelerations of all joints from `motion` on, and from `links` on room for `N_LINK` numbers of the ground and
        of each link.
    motion, links : int
    push : Vector, N
        At the tip.
    pitch, roll : float, rad
        How the ground rises; weight turns with it.
    """
    n = body.parent.shape[0]
    for k in range(N_LINK):
        live[links + k] = 1.0 if k == 0 or k == 4 or k == 8 else 0.0
    still = point_of(body.still, 0)
    whole, first, momentum = body.still_mass, times(body.still_mass, still), Vector(0.0, 0.0, 0.0)
    force = Vector(push.x, push.y, push.z - body.still_mass * body.gravity)
    moment = cross_product(still, Vector(0.0, 0.0, -body.still_mass * body.gravity))  # about the origin
    for i in range(n):
        move_link(body, live, motion, links, i)
        link = links + N_LINK * (i + 1)
        mass = body.mass[i]
        spin = point_of(live, link + SPIN)
        twist = point_of(live, link + TWIST)
        centre = turned(live, link, point_of(body.cg, 3 * i))
        place = plus(point_of(live, link + PLACE), centre)
        own = carried(spin, twist, centre)
        swept = cross_product(spin, centre)
        whirling = spun(body, live, link, i, spin)
        turning = spun(body, live, link, i, twist)
        whirl = cross_product(spin, whirling)
        needed = Vector(
            mass * (live[link + GAINED] + own.x),
            mass * (live[link + GAINED + 1] + own.y),
            mass * (live[link + GAINED + 2] + own.z + body.gravity),
        )
        about = cross_product(place, needed)
        whole += mass
        first = Vector(first.x + mass * place.x, first.y + mass * place.y, first.z + mass * place.z)
        momentum = Vector(
            momentum.x + mass * (live[link + SPEED] + swept.x),
            momentum.y + mass * (live[link + SPEED + 1] + swept.y),
            momentum.z + mass * (live[link + SPEED + 2] + swept.z),
        )
        force = Vector(force.x - needed.x, force.y - needed.y, force.z - needed.z)
        moment = Vector(
            moment.x - about.x - turning.x - whirl.x,
            moment.y - about.y - turning.y - whirl.y,
            moment.z - about.z - turning.z - whirl.z,
        )
    hand = links + N_LINK * (body.tip_link + 1)
    reach = plus(point_of(live, hand + PLACE), turned(live, hand, point_of(body.tip, 0)))
    pushed = cross_product(reach, push)
    cg = times(1.0 / whole, first)
    upward = upward_on(pitch, roll)
    weight = whole * body.gravity
    about_cg = cross_product(cg, force)
    return Standing(
        weight,
        cg,
        times(1.0 / whole, momentum),
        # weight acts at the centre of gravity
        Vector(force.x - weight * upward.x, force.y - weight * upward.y, force.z + weight * (1.0 - upward.z)),
        Vector(moment.x + pushed.x - about_cg.x, moment.y + pushed.y - about_cg.y, moment.z + pushed.z - about_cg.z),
        upward,
    )


@kernel
def edge_of(body: Body, k: int, s: Standing) -> EdgeMargins:
    """Margins over one edge, from a corner to the next."""
    after = k + 1 if k + 1 < body.n_edge else 0
    begin = point_of(body.corners, 3 * k)
    end = point_of(body.corners, 3 * after)
    return edge_margins(begin, end, s)
