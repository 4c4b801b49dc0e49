"""Which network answers, and its value: every network as straight-line code, or all of them as tables.

The form is chosen here alone, by the number of networks. Straight-line code is faster (constants stand in it), and of a few networks not
long; tables are some ten times shorter, and compile at once. Both do the same operations in the same order and give the same bits.
"""

import numpy as np

from polydraulic.export.c.network import choice, helpers, input_limits, slopes_function, value_function
from polydraulic.export.c.tables import first_networks, regions, table_helpers, tables
from polydraulic.export.c.text import Real, block_comment, literal
from polydraulic.export.model_bundle import Bundle
from polydraulic.networks.model.partition import Split
from polydraulic.networks.model.slopes import domain_gain

STRAIGHT = 8  # networks of all outputs, at most, that become straight-line code


def as_tables(whole: Bundle) -> bool:
    """Whether the networks are written as tables."""
    return sum(len(model.networks) for model in whole.models) > STRAIGHT


def form_lines(whole: Bundle) -> list[str]:
    """The form in words, for the header."""
    count = sum(len(model.networks) for model in whole.models)
    networks = f"{count} networks" if count > 1 else "The network"
    if as_tables(whole):
        return [
            f"{networks} as tables, which one function reads. Up to {STRAIGHT} would be straight-line code each, which is faster and",
            "longer, and gives the same bits.",
        ]
    return [f"{networks} as straight-line code. More than {STRAIGHT} would be tables, which give the same bits."]


def answering_code(whole: Bundle, real: Real) -> str:
    """Functions and tables that `region_call` and `value_call` use, and domains for all outputs."""
    domains = [_domain(whole, k, real) for k in range(len(whole.models))]
    if as_tables(whole):
        return table_helpers(whole, real) + tables(whole, real) + "\n" + "\n".join(domains)
    parts = [f"{_straight(whole, k, real)}\n{domain}" for k, domain in enumerate(domains)]
    return helpers(whole.models, real) + "\n".join(parts)


def region_call(whole: Bundle, k: int) -> str:
    """Expression for the network of output `k` that answers for x, counted from its first one."""
    if as_tables(whole):
        return regions(whole)[k]
    return f"region_{k}(x)" if isinstance(whole.models[k].partition, Split) else "0"


def value_call(whole: Bundle, k: int, slopes: str | None = None) -> str:
    """Statements that put the value of the network r`k` into y; with `slopes`, an expression, also its slopes there."""
    count = len(whole.models[k].networks)
    if as_tables(whole):
        arguments = (
            f"{first_networks(whole)[k]} + r{k}, {len(whole.places[k])}, place_{k}, low_{k}[r{k}], high_{k}[r{k}], x"
        )
        called = f"own_value({arguments})" if slopes is None else f"own_slopes_of({arguments}, {slopes})"
        return f"    y[{k}] = {called};"
    ending, more = ("", "") if slopes is None else ("_slopes", f", {slopes}")
    calls = [f"y[{k}] = value_{k}_{j}{ending}(x{more});" for j in range(count)]
    if count == 1:
        return f"    {calls[0]}"
    cases = [f"    case {j}:\n        {call}\n        break;" for j, call in enumerate(calls[:-1])]
    return "\n".join([f"    switch (r{k}) {{", *cases, f"    default:\n        {calls[-1]}\n        break;", "    }"])


def numbers_row(values: np.ndarray, real: Real) -> str:
    """Numbers as an initializer."""
    return f"{{{', '.join(literal(float(value), real) for value in values)}}}"


def _straight(whole: Bundle, k: int, real: Real) -> str:
    """Functions of output `k`: networks with and without slopes, and regions."""
    model, place, n = whole.models[k], whole.places[k], len(whole.inputs)
    parts = []
    for j, (network, where) in enumerate(zip(model.networks, model.region_names(), strict=True)):
        about = block_comment([f"{model.output.name}: {where}"])[3:-3].strip(" *\n")
        parts += [f(f"value_{k}_{j}", network, place, n, about, real) for f in (value_function, slopes_function)]
    if isinstance(model.partition, Split):
        way = "\n".join(choice(model.partition, place, real))
        parts.append(f"static int region_{k}(const {real.name} x[{n}])\n{{\n{way}\n}}\n")
    return "\n".join(parts)


def _domain(whole: Bundle, k: int, real: Real) -> str:
    """Tables of the domains of the networks of output `k`, and whether x is outside of one."""
    model, place, n, t = whole.models[k], whole.places[k], len(whole.inputs), real.name
    low, high = np.moveaxis(np.array([input_limits(network, real) for network in model.networks]), 2, 0)
    size = f"[{len(model.networks)}][{len(place)}]"
    lines = [
        f"static const {t} {what}_{k}{size} = {{{', '.join(numbers_row(values, real) for values in table)}}};"
        for what, table in (("low", low), ("high", high), ("share", domain_gain(low, high)))
    ]
    lines.append(f"static const int place_{k}[{len(place)}] = {{{', '.join(map(str, place))}}};")
    tests = [f"!(x[{p}] >= low_{k}[r][{i}]) || !(x[{p}] <= high_{k}[r][{i}])" for i, p in enumerate(place)]
    return (
        "\n".join(lines)
        + f"""

/* Also if an input is not a number. */
static int outside_{k}(const {t} x[{n}], int r)
{{
    return ({f"{chr(10)}        || ".join(tests)}) ? 1 : 0;
}}
"""
    )
