"""Valves in series once more, with as many digits as it takes: for states in which twice the machine's precision does not decide.

The same bisection as `series_judge`, in decimal numbers of a hundred digits: slow, and sure of every state.
"""

from decimal import Context, Decimal, localcontext

import numpy as np

from helpers.series_judge import judge_all

DIGITS = 100
SURE = 1e-13  # of pump flow, of the judge in twice the machine's precision
_SHUT = Decimal("1e60")  # Pa, above all others


def _delivered(p, pump):
    start = Decimal(float(pump.limit_start))
    if pump.log_least == 0.0 or p <= start:
        return Decimal(float(pump.flow))
    return Decimal(float(pump.flow)) * (start / p) ** Decimal(float(pump.limit_exponent))


def _climbed(t, last, kink, inlet, bypass, port, pump):
    """Flows for a root t at node `last`, pressure of the pump, and whether the pump cannot give that."""
    n, p = len(inlet), kink + t * t
    flows = [Decimal(0)] * (n + 1)

    def through(k, at, to):
        return k * (t if at == kink + t * t and to == kink else max(at - to, Decimal(0)).sqrt())

    if last == n - 1:
        flows[n] = through(bypass[last], p, Decimal(float(pump.p_return)))
    total = flows[n]
    for i in range(last, -1, -1):
        if i < last:
            if not bypass[i]:
                return flows, _SHUT, True
            p += (total / bypass[i]) ** 2
        flows[i] = through(inlet[i], p, port[i])
        total += flows[i]
    relief = Decimal(float(pump.relief))
    return flows, p, p > relief or total > _delivered(p, pump)


def judged_exactly(inlet, bypass, port, pump):
    """Flows of the inlets, to the tank, of the pump and over the relief valve, and how unsure (share of pump flow)."""
    with localcontext(Context(prec=DIGITS)):
        inlet, bypass, port = ([Decimal(float(x)) for x in part] for part in (inlet, bypass, port))
        n, relief, back = len(inlet), Decimal(float(pump.relief)), Decimal(float(pump.p_return))
        for last in range(n - 1, -1, -1):
            kinks = [port[last]] if inlet[last] else []
            kinks += [back] if last == n - 1 and bypass[last] else []
            if not kinks or _climbed(Decimal(0), last, min(kinks), inlet, bypass, port, pump)[2]:
                continue
            low, high = Decimal(0), relief.sqrt() + 1
            for _ in range(4 * DIGITS):
                middle = (low + high) / 2
                if not low < middle < high or high < Decimal("1e-60"):
                    break
                asks = _climbed(middle, last, min(kinks), inlet, bypass, port, pump)[2]
                low, high = (low, middle) if asks else (middle, high)
            flows, p, _ = _climbed(low, last, min(kinks), inlet, bypass, port, pump)
            other, above, _ = _climbed(high, last, min(kinks), inlet, bypass, port, pump)
            at_relief = above > relief and sum(other) <= _delivered(relief, pump)
            q = _delivered(relief if at_relief else p, pump)
            unsure = max(abs(a - b) for a, b in zip(flows, other, strict=True))
            unsure = max(unsure, abs(q - _delivered(min(above, relief), pump)))
            found = [*flows, q, max(q - sum(flows), Decimal(0))]
            return np.array([float(x) for x in found]), float(unsure) / pump.flow
        q = _delivered(relief, pump)
        return np.array([0.0] * (n + 1) + [float(q), float(q)]), 0.0


def judged_surely(states, pump):
    """Flows of all states, where `series_judge` is not sure by a hundred digits; how many these are, and the largest doubt that is left."""
    n = states[0].shape[1]
    out = np.empty((len(states[0]), n + 5))
    judge_all(*states, pump, out)
    again = np.flatnonzero(~(out[:, n + 4] <= SURE))
    for i in again:
        out[i, : n + 3], out[i, n + 4] = judged_exactly(*(part[i] for part in states), pump)
    return out[:, : n + 3], len(again), out[:, n + 4].max(initial=0.0)
