"""Two pumps joined by a crossover valve, solved another way: brackets inside brackets on the pressures of all nodes, in double-double.

At a pressure behind the crossover each pump finds the pressure at which it delivers what leaves its node, within that the giving pump's bypass finds
the pressure behind it. Brackets begin near pressures that are given, and are those of all pressures where the signs at their ends say otherwise. What
every node is short of in the end is the judge's doubt: flows are nowhere further off than its sum.
"""

from helpers.double_double import above, add, compiled, minus, root, times
from helpers.series_judge import SHUT, delivered

_CLOSE = 2e-16  # of pump flow
_NEAR = 1e-9  # of a pressure that is given; a pressure in front moves by no more than that behind
_STEPS = 300


@compiled
def through(k, p, to):
    """Flow of an orifice with check valve; pressures of twice the precision."""
    if k == 0.0 or not above(p, to):
        return 0.0, 0.0
    return times((k, 0.0), root(add(p, minus(to))))


@compiled
def between(low, high, off_low, off_high, step, near):
    """Next place in a bracket: first both sides of the given pressure, then where the chord vanishes, now and then half way."""
    if step < 2:
        return start(near, low, high, 1.0 - 2.0 * step)
    share = 0.5
    if step % 6 != 5 and step < 60 and off_low - off_high > 0.0:
        share = off_low / (off_low - off_high)
        share = share if 0.0 < share < 1.0 else 0.5
    return add(low, times(add(high, minus(low)), (share, 0.0)))


@compiled
def narrowed(m, off, low, high, off_low, off_high, last):
    """A bracket with a new end; one that stays twice counts half."""
    if off > 0.0:
        return m, high, off, (0.5 * off_high if last == -1 else off_high), -1
    return low, m, (0.5 * off_low if last == 1 else off_low), off, 1


@compiled
def stuck(p, low, high):
    return not above(p, low) or not above(high, p)


@compiled
def start(near, low, high, side):
    """An end of a first bracket about a pressure, which must be within the whole one; `near` holds the pressure and how far from it."""
    p = (near[0] + side * near[1], 0.0)
    return p if above(p, low) and above(high, p) else (low if side < 0.0 else high)


@compiled
def behind(p, bypass, inlet, tank, p_in, p_return, flow, near):
    """Flows into the valve behind a bypass and to its tank, and what that node is short of."""
    zero = (0.0, 0.0)
    low = (min(p_in if inlet > 0.0 else SHUT, p_return if tank > 0.0 else SHUT), 0.0)
    if bypass == 0.0 or not above(p, low):
        return zero, zero, 0.0
    high, off_low, off_high, last = p, flow, -flow, 0
    q, t, off = zero, zero, 0.0
    for step in range(_STEPS):
        m = between(low, high, off_low, off_high, step, near)
        if step >= 2 and stuck(m, low, high):
            break
        q, t = through(inlet, m, (p_in, 0.0)), through(tank, m, (p_return, 0.0))
        off = add(through(bypass, p, m), minus(add(q, t)))[0]
        if abs(off) <= _CLOSE * flow:
            break
        low, high, off_low, off_high, last = narrowed(m, off, low, high, off_low, off_high, last)
    return q, t, abs(off)


@compiled
def giving_at(p, k, b, ports, cross, p_behind, gives, near):
    """Flows that leave the giving pump's node at a pressure, what is left of its flow, and doubt."""
    q_1 = through(k[0], p, (ports[0], 0.0))
    q_2, tank, doubt = behind(p, b[0], k[1], b[1], ports[1], gives.p_return, gives.flow, near)
    x, pump = through(cross[0], p, add(p_behind, (cross[1], 0.0))), delivered(p, gives)
    rest = add(pump, minus(add(add(q_1, x), add(q_2, tank))))
    return q_1, q_2, tank, x, pump, rest, doubt


@compiled
def giving(k, b, ports, cross, p_behind, gives, near):
    """The giving pump at a pressure behind the crossover."""
    high = (gives.relief, 0.0)
    found = giving_at(high, k, b, ports, cross, p_behind, gives, near[1])
    if found[5][0] >= 0.0:
        return high, found
    low, off_low, off_high, last, p = (0.0, 0.0), gives.flow, found[5][0], 0, high
    for step in range(_STEPS):
        m = between(low, high, off_low, off_high, step, near[0])
        if step >= 2 and stuck(m, low, high):
            break
        p, found = m, giving_at(m, k, b, ports, cross, p_behind, gives, near[1])
        off = found[5][0]
        if abs(off) <= _CLOSE * gives.flow:
            break
        low, high, off_low, off_high, last = narrowed(m, off, low, high, off_low, off_high, last)
    return p, found


@compiled
def taking_at(p, inlet, bypass, port, p_behind, takes):
    q, w, pump = through(inlet, p, (port, 0.0)), through(bypass, p, p_behind), delivered(p, takes)
    return q, w, pump, add(pump, minus(add(q, w)))


@compiled
def taking(inlet, bypass, port, p_behind, takes, near):
    """The taking pump and its first valve at a pressure behind that."""
    high = (takes.relief, 0.0)
    found = taking_at(high, inlet, bypass, port, p_behind, takes)
    if found[3][0] >= 0.0:
        return high, found
    low, off_low, off_high, last, p = (0.0, 0.0), takes.flow, found[3][0], 0, high
    for step in range(_STEPS):
        m = between(low, high, off_low, off_high, step, near)
        if step >= 2 and stuck(m, low, high):
            break
        p, found = m, taking_at(m, inlet, bypass, port, p_behind, takes)
        off = found[3][0]
        if abs(off) <= _CLOSE * takes.flow:
            break
        low, high, off_low, off_high, last = narrowed(m, off, low, high, off_low, off_high, last)
    return p, found


@compiled
def judged(cross, k, b, ports, gives, takes, near, out):
    """`cross` is conductance and opening pressure. Fill `out`: flows of four inlets and of the crossover; of each pump its flow, to the tank, over relief, pressure; doubt (share of pump flow)."""
    low = (min(ports[3] if k[3] > 0.0 else SHUT, takes.p_return if b[3] > 0.0 else SHUT), 0.0)
    top = (max(gives.relief, takes.relief), 0.0)
    flow = gives.flow + takes.flow
    width = _NEAR * max(near[0], near[2], near[3]) + 1e-6
    around = (near[0], 3.0 * width), (near[1], 10.0 * width), (near[2], 3.0 * width), (near[3], width)
    m = top
    high, off_low, off_high, last = top, flow, -flow, 0
    left, right = giving(k, b, ports, cross, m, gives, around), taking(k[2], b[2], ports[2], m, takes, around[2])
    q, t, off = (0.0, 0.0), (0.0, 0.0), 0.0
    if above(top, low):
        for step in range(_STEPS):
            m = between(low, high, off_low, off_high, step, around[3])
            if step >= 2 and stuck(m, low, high):
                break
            left, right = (
                giving(k, b, ports, cross, m, gives, around),
                taking(k[2], b[2], ports[2], m, takes, around[2]),
            )
            q, t = through(k[3], m, (ports[3], 0.0)), through(b[3], m, (takes.p_return, 0.0))
            off = add(add(left[1][3], right[1][1]), minus(add(q, t)))[0]
            if abs(off) <= 10.0 * _CLOSE * flow:
                break
            low, high, off_low, off_high, last = narrowed(m, off, low, high, off_low, off_high, last)
    p_left, (q_1, q_2, tank, x, pump_left, rest_left, doubt) = left
    p_right, (q_3, _, pump_right, rest_right) = right
    out[0], out[1], out[2], out[3], out[4] = q_1[0], q_2[0], q_3[0], q[0], x[0]
    out[5], out[6], out[8] = pump_left[0], tank[0], p_left[0]
    out[9], out[10], out[12] = pump_right[0], t[0], p_right[0]
    at_relief = p_left[0] >= gives.relief, p_right[0] >= takes.relief
    out[7] = max(rest_left[0], 0.0) if at_relief[0] else 0.0
    out[11] = max(rest_right[0], 0.0) if at_relief[1] else 0.0
    doubt += abs(off) + abs(rest_left[0] - out[7]) + abs(rest_right[0] - out[11])
    out[13] = doubt / flow


@compiled
def judge_all(crosses, k, b, ports, gives, takes, near, out):
    """Rows of states, with pressures to begin near: of the giving pump, behind its first valve, of the taking pump and behind its first valve."""
    for i in range(crosses.shape[0]):
        judged(crosses[i], k[i], b[i], ports[i], gives, takes, near[i], out[i])
