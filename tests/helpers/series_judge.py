"""Any number of valves in series, solved another way: bisection in double-double from the last node that flow reaches.

At that node the pressure is its lowest open port's plus t squared; everything up to the pump follows from t. Arrays: valves from the pump on.
"""

import numpy as np

from helpers.double_double import above, add, compiled, divided, minus, root, times

SHUT = 1e40  # Pa, above all others


@compiled
def delivered(p, pump):
    """Flow of the pump; exponents of the torque limit 0.5, 1 and 2."""
    if pump.log_least == 0.0 or not above(p, (pump.limit_start, 0.0)):
        return pump.flow, 0.0
    ratio = divided((pump.limit_start, 0.0), p)
    if pump.limit_exponent == 2.0:
        ratio = times(ratio, ratio)
    if pump.limit_exponent == 0.5:
        ratio = root(ratio)
    return times((pump.flow, 0.0), ratio)


@compiled
def to_outlet(k, p, port, kink, t):
    """Flow through an orifice to a port; t itself where the pressure is counted from this port."""
    if k == 0.0:
        return 0.0, 0.0
    return times((k, 0.0), t if port == kink else root(add(p, (-port, 0.0))))


@compiled
def climb(t, last, kink, inlet, bypass, port, pump, flows, pressures):
    """Flows (inlets, then the tank) and pressures for a root t at node `last`; whether the pump cannot give that."""
    n = inlet.size
    flows[:] = 0.0
    pressures[:] = 0.0
    p = add((kink, 0.0), times(t, t))
    total = (0.0, 0.0)
    if last == n - 1:
        total = to_outlet(bypass[last], p, pump.p_return, kink, t)
        flows[n, 0], flows[n, 1] = total
    for i in range(last, -1, -1):
        if i < last:
            if bypass[i] == 0.0:
                return True
            drop = divided(total, (bypass[i], 0.0))
            p = add(p, times(drop, drop))
        if p[0] > SHUT:
            return True
        q = to_outlet(inlet[i], p, port[i], kink if i == last else -1.0, t)
        flows[i, 0], flows[i, 1] = q
        pressures[i] = p[0]
        total = add(total, q)
    return above(p, (pump.relief, 0.0)) or above(total, delivered(p, pump))


@compiled
def judged(inlet, bypass, port, pump, out, flows, other, pressures):
    """Fill `out`: flows of the inlets, to the tank, of the pump, over the relief valve, its pressure; how unsure (share of pump flow).

    The answer lies between two neighbouring numbers; where the upper one exceeds the relief pressure alone, the relief valve is open.
    """
    n = inlet.size
    out[:] = 0.0
    zero = (0.0, 0.0)
    for last in range(n - 1, -1, -1):
        kink = SHUT
        if inlet[last] > 0.0:
            kink = port[last]
        if last == n - 1 and bypass[last] > 0.0:
            kink = min(kink, pump.p_return)
        if kink == SHUT or climb(zero, last, kink, inlet, bypass, port, pump, flows, pressures):
            continue
        low, high = zero, (pump.relief**0.5 + 1.0, 0.0)
        for _ in range(400):
            middle = add(low, high)
            middle = (0.5 * middle[0], 0.5 * middle[1])
            if not above(middle, low) or not above(high, middle) or high[0] < 1e-25:
                break
            if climb(middle, last, kink, inlet, bypass, port, pump, flows, pressures):
                high = middle
            else:
                low = middle
        climb(high, last, kink, inlet, bypass, port, pump, other, pressures)
        asked, at_relief, high_flow = zero, pressures[0] > pump.relief, delivered((pump.relief, 0.0), pump)
        for i in range(n + 1):
            asked = add(asked, (other[i, 0], other[i, 1]))
        at_relief = at_relief and not above(asked, high_flow)
        high_flow = high_flow if at_relief else delivered((min(pressures[0], pump.relief), 0.0), pump)
        climb(low, last, kink, inlet, bypass, port, pump, flows, pressures)
        total = zero
        for i in range(n + 1):
            out[i] = flows[i, 0]
            out[n + 4] = max(out[n + 4], abs(other[i, 0] - flows[i, 0]) / pump.flow)
            total = add(total, (flows[i, 0], flows[i, 1]))
        p = pump.relief if at_relief else pressures[0]
        q = delivered((p, 0.0), pump)
        out[n + 4] = max(out[n + 4], abs(high_flow[0] - q[0]) / pump.flow)
        out[n + 1], out[n + 2], out[n + 3] = q[0], max(add(q, minus(total))[0], 0.0), p
        return
    q = delivered((pump.relief, 0.0), pump)
    out[n + 1], out[n + 2], out[n + 3] = q[0], q[0], pump.relief


@compiled
def judge_all(inlets, bypasses, ports, pump, out):
    """Rows of states; see `judged`."""
    n = inlets.shape[1]
    flows, other, pressures = np.empty((n + 1, 2)), np.empty((n + 1, 2)), np.empty(n)
    for i in range(inlets.shape[0]):
        judged(inlets[i], bypasses[i], ports[i], pump, out[i], flows, other, pressures)
