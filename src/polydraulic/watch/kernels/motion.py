"""Steps at instants of a motion: filters, friction, and the torque that links need to move so (Newton and Euler along the tree)."""

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.elementary import exp, sincos, tanh

# of a link in `floats`: where its joint is, mass, centre of gravity, inertia, sign of its axis
_MASS, _CENTRE, _INERTIA, _SIGN, NUMBERS_OF_LINK = 3, 4, 7, 16, 17
# of a link in `work`: turn, origin, spin, twist, acceleration of its joint; force and moment that it needs
_ORIGIN, _SPIN, _TWIST, _AT, _FORCE, _MOMENT, ROOM_OF_LINK = 9, 12, 15, 18, 21, 24, 27


@driver
def convolved(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Weighted sums of rows about instants."""
    out, n, of, weights, long = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    first, stride = ints[s + 5], ints[s + 6]
    for i in range(n):
        total = 0.0
        for k in range(long):
            total += work[of + first + i * stride + k] * floats[weights + k]
        work[out + i] = total


@driver
def oil_torque(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Weighted sums of what both pressures do through their levers."""
    out, n, lever_a, a, lever_b = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    b, weights, long, first, stride = ints[s + 5], ints[s + 6], ints[s + 7], ints[s + 8], ints[s + 9]
    for i in range(n):
        total = 0.0
        for k in range(long):
            at = first + i * stride + k
            total += (work[lever_a + at] * work[a + at] - work[lever_b + at] * work[b + at]) * floats[weights + k]
        work[out + i] = total


@kernel
def friction_at(rate: float, coulomb: float, static: float, stribeck: float, viscous: float, smoothing: float) -> float:
    """Friction of a joint that moves at a rate."""
    share = rate / stribeck
    level = coulomb + (static - coulomb) * exp(-(share * share))
    return level * tanh(rate / smoothing) + viscous * rate


@driver
def friction(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Friction at instants."""
    out, n, rate, k = ints[s], ints[s + 1], ints[s + 2], ints[s + 3]
    for i in range(n):
        work[out + i] = friction_at(
            work[rate + i], floats[k], floats[k + 1], floats[k + 2], floats[k + 3], floats[k + 4]
        )


@driver
def add_friction_unsure(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Add to a variance what nobody knows of friction: a share of it, and at rest anything up to static friction."""
    out, n, rate, k = ints[s], ints[s + 1], ints[s + 2], ints[s + 3]
    share, held = floats[k + 5], floats[k + 6]
    for i in range(n):
        w = work[rate + i]
        known = share * friction_at(w, floats[k], floats[k + 1], floats[k + 2], floats[k + 3], floats[k + 4])
        moving = tanh(w / floats[k + 4])
        rests = held * (1.0 - moving * moving)
        work[out + i] += known * known + rests * rests


@driver
def torque_left(ints: np.ndarray, work: np.ndarray, s: int) -> None:
    """Torque of the oil less friction and that which the motion needs."""
    out, n, oil, rubbed, needed = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        work[out + i] = work[oil + i] - work[rubbed + i] - work[needed + i]


@driver
def needed_torques(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Torque, or force, that a motion needs of each joint.

    Behind the first five places stand six of each link: its parent (-1: the ground), axis (0 to 2), whether it slides, and where its positions,
    rates and accelerations are. Parents come first; the output has n numbers of each link.
    """
    out, n, links, numbers, room = ints[s], ints[s + 1], ints[s + 2], ints[s + 3], ints[s + 4]
    for i in range(n):
        for link in range(links):
            _moved(ints, floats, work, s + 5 + 6 * link, numbers + 1 + link * NUMBERS_OF_LINK, room, link, i)
            _own_wrench(floats, work, numbers, numbers + 1 + link * NUMBERS_OF_LINK, room + link * ROOM_OF_LINK)
        for back in range(links):
            outer = links - 1 - back
            inner = ints[s + 5 + 6 * outer]
            if inner >= 0:
                _carried(work, room + inner * ROOM_OF_LINK, room + outer * ROOM_OF_LINK)
        for link in range(links):
            parent, axis, slides = ints[s + 5 + 6 * link], ints[s + 6 + 6 * link], ints[s + 7 + 6 * link]
            own = room + link * ROOM_OF_LINK + (_FORCE if slides != 0 else _MOMENT)
            total = 0.0
            for c in range(3):
                total += work[own + c] * _axis(work, parent, axis, room, c)
            work[out + link * n + i] = floats[numbers + 1 + link * NUMBERS_OF_LINK + _SIGN] * total


@driver
def _axis(work: np.ndarray, parent: int, axis: int, room: int, c: int) -> float:
    """A joint's axis along the ground's."""
    along = 1.0 if c == axis else 0.0
    if parent >= 0:
        along = work[room + parent * ROOM_OF_LINK + 3 * c + axis]
    return along


@driver
def _moved(
    ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int, number: int, room: int, link: int, i: int
) -> None:
    """Turn, origin and motion of a link from those of its parent."""
    parent, axis, slides = ints[s], ints[s + 1], ints[s + 2]
    sign = floats[number + _SIGN]
    q = sign * work[ints[s + 3] + i]
    w, a = sign * work[ints[s + 4] + i], sign * work[ints[s + 5] + i]
    own = room + link * ROOM_OF_LINK
    before = room + parent * ROOM_OF_LINK
    first = axis + 1 if axis < 2 else 0
    second = 3 - axis - first
    turned = sincos(0.0 if slides != 0 else q)
    # along the parent's axes
    for r in range(3):
        for c in range(3):
            work[own + 3 * r + c] = 1.0 if r == c else 0.0
        work[own + _ORIGIN + r] = floats[number + r] + (q if slides != 0 and r == axis else 0.0)
        for c in range(_SPIN, _FORCE):
            work[own + c] = 0.0
    work[own + 3 * first + first] = turned.cos
    work[own + 3 * second + second] = turned.cos
    work[own + 3 * second + first] = turned.sin
    work[own + 3 * first + second] = -turned.sin
    if parent >= 0:
        _placed(work, before, own)
        for c in range(_SPIN, _FORCE):
            work[own + c] = work[before + c]
        # the force is a place for the joint's arm, until it is known
        for c in range(3):
            work[own + _FORCE + c] = work[own + _ORIGIN + c] - work[before + _ORIGIN + c]
        _add_acceleration(work, own + _AT, own + _SPIN, own + _TWIST, own + _FORCE)
    x, y, z = _axis(work, parent, axis, room, 0), _axis(work, parent, axis, room, 1), _axis(work, parent, axis, room, 2)
    u, v, t = work[own + _SPIN], work[own + _SPIN + 1], work[own + _SPIN + 2]
    grown = own + (_AT if slides != 0 else _TWIST)
    whirl = 2.0 * w if slides != 0 else w
    work[grown] += x * a + whirl * (v * z - t * y)
    work[grown + 1] += y * a + whirl * (t * x - u * z)
    work[grown + 2] += z * a + whirl * (u * y - v * x)
    spun = 0.0 if slides != 0 else w
    work[own + _SPIN] += spun * x
    work[own + _SPIN + 1] += spun * y
    work[own + _SPIN + 2] += spun * z


@driver
def _placed(work: np.ndarray, before: int, own: int) -> None:
    """Turn and origin that are given along the parent's axes, along the ground's; the motion's places are used meanwhile."""
    kept = own + _SPIN
    for r in range(3):
        for c in range(3):
            work[kept + 3 * r + c] = (
                work[before + 3 * r] * work[own + c]
                + work[before + 3 * r + 1] * work[own + 3 + c]
                + work[before + 3 * r + 2] * work[own + 6 + c]
            )
    x, y, z = work[own + _ORIGIN], work[own + _ORIGIN + 1], work[own + _ORIGIN + 2]
    for r in range(3):
        turned = work[before + 3 * r] * x + work[before + 3 * r + 1] * y + work[before + 3 * r + 2] * z
        work[own + _ORIGIN + r] = work[before + _ORIGIN + r] + turned
    for c in range(9):
        work[own + c] = work[kept + c]


@driver
def _add_acceleration(work: np.ndarray, out: int, spin: int, twist: int, arm: int) -> None:
    """Add what a point at the end of an arm has more than its beginning."""
    u, v, t = work[spin], work[spin + 1], work[spin + 2]
    x, y, z = work[arm], work[arm + 1], work[arm + 2]
    a, b, c = v * z - t * y, t * x - u * z, u * y - v * x
    d, e, f = work[twist], work[twist + 1], work[twist + 2]
    work[out] += (e * z - f * y) + (v * c - t * b)
    work[out + 1] += (f * x - d * z) + (t * a - u * c)
    work[out + 2] += (d * y - e * x) + (u * b - v * a)


@driver
def _turned(work: np.ndarray, own: int, r: int, x: float, y: float, z: float) -> float:
    """Component along one of the ground's axes of what is given along a link's."""
    return work[own + 3 * r] * x + work[own + 3 * r + 1] * y + work[own + 3 * r + 2] * z


@driver
def _spun(floats: np.ndarray, work: np.ndarray, number: int, own: int, of: int, r: int) -> float:
    """Component along a link's axis of its inertia times a rate that is given along the ground's axes."""
    total = 0.0
    for c in range(3):
        along = work[own + c] * work[of] + work[own + 3 + c] * work[of + 1] + work[own + 6 + c] * work[of + 2]
        total += floats[number + _INERTIA + 3 * r + c] * along
    return total


@driver
def _own_wrench(floats: np.ndarray, work: np.ndarray, gravity: int, number: int, own: int) -> None:
    """Force, and moment about its joint, that a link needs for itself."""
    mass = floats[number + _MASS]
    p, q, r = floats[number + _CENTRE], floats[number + _CENTRE + 1], floats[number + _CENTRE + 2]
    for c in range(3):
        work[own + _MOMENT + c] = _turned(work, own, c, p, q, r)
        work[own + _FORCE + c] = work[own + _AT + c]
    _add_acceleration(work, own + _FORCE, own + _SPIN, own + _TWIST, own + _MOMENT)
    x, y, z = work[own + _MOMENT], work[own + _MOMENT + 1], work[own + _MOMENT + 2]
    work[own + _FORCE] = mass * work[own + _FORCE]
    work[own + _FORCE + 1] = mass * work[own + _FORCE + 1]
    work[own + _FORCE + 2] = mass * (work[own + _FORCE + 2] + floats[gravity])
    a, b, c_3 = work[own + _FORCE], work[own + _FORCE + 1], work[own + _FORCE + 2]
    k, m, n = (
        _spun(floats, work, number, own, own + _SPIN, 0),
        _spun(floats, work, number, own, own + _SPIN, 1),
        _spun(floats, work, number, own, own + _SPIN, 2),
    )
    d, e, f = (
        _spun(floats, work, number, own, own + _TWIST, 0),
        _spun(floats, work, number, own, own + _TWIST, 1),
        _spun(floats, work, number, own, own + _TWIST, 2),
    )
    h_1, h_2, h_3 = (
        _turned(work, own, 0, k, m, n),
        _turned(work, own, 1, k, m, n),
        _turned(work, own, 2, k, m, n),
    )
    u, v, t = work[own + _SPIN], work[own + _SPIN + 1], work[own + _SPIN + 2]
    work[own + _MOMENT] = _turned(work, own, 0, d, e, f) + (v * h_3 - t * h_2) + (y * c_3 - z * b)
    work[own + _MOMENT + 1] = _turned(work, own, 1, d, e, f) + (t * h_1 - u * h_3) + (z * a - x * c_3)
    work[own + _MOMENT + 2] = _turned(work, own, 2, d, e, f) + (u * h_2 - v * h_1) + (x * b - y * a)


@driver
def _carried(work: np.ndarray, before: int, own: int) -> None:
    """Add to what a parent needs that which its child does."""
    x = work[own + _ORIGIN] - work[before + _ORIGIN]
    y = work[own + _ORIGIN + 1] - work[before + _ORIGIN + 1]
    z = work[own + _ORIGIN + 2] - work[before + _ORIGIN + 2]
    a, b, c = work[own + _FORCE], work[own + _FORCE + 1], work[own + _FORCE + 2]
    work[before + _FORCE] += a
    work[before + _FORCE + 1] += b
    work[before + _FORCE + 2] += c
    work[before + _MOMENT] += work[own + _MOMENT] + (y * c - z * b)
    work[before + _MOMENT + 1] += work[own + _MOMENT + 1] + (z * a - x * c)
    work[before + _MOMENT + 2] += work[own + _MOMENT + 2] + (x * b - y * a)
