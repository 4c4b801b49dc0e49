"""Networks in rational numbers: the judge of proved bounds."""

from decimal import Decimal, localcontext
from fractions import Fraction

from polydraulic.networks.model.nodes import RAMP, SIGMOID, terms


def exact_output(network, x):
    """Output without clamps, of inputs that may be rational; sigmoids to sixty digits."""
    v = [(Fraction(a) - Fraction(m)) / Fraction(s) for a, m, s in zip(x, network.x_mean, network.x_scale, strict=True)]
    last = Fraction(0)
    for node in network.nodes:
        last = Fraction(0)
        for c, exponents in zip(node.coef, terms(node.kind, len(node.inputs)), strict=True):
            term = Fraction(c)
            for slot, e in zip(node.inputs, exponents, strict=True):
                term *= v[slot] ** e
            last += term
        last = _logistic(last) if node.kind == SIGMOID else last
        last = min(max(last, Fraction(0)), Fraction(1)) if node.kind == RAMP else last
        v.append(last)
    return Fraction(network.y_mean) + Fraction(network.y_scale) * last


def _logistic(h):
    with localcontext() as context:
        context.prec = 60
        return Fraction(1 / (1 + (-Decimal(h.numerator) / Decimal(h.denominator)).exp()))
