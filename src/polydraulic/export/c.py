"""A model as C99: one header and one source, no allocation, no input or output, no state.

Polynomials are nested as in `networks.table.evaluate`, and numbers are written so that they read back exactly; a
compiler that keeps to C99 (no fused multiply-adds) gives the same bits as the package.
"""

import re
from collections.abc import Sequence
from pathlib import Path

from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.networks import Model, Network, Node
from polydraulic.networks.nodes import DOUBLE, KIND_NAMES, LINEAR, SIGMOID, SINGLE
from polydraulic.networks.partition import Partition, Split
from polydraulic.networks.table import UNBOUNDED

_KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "main NULL".split()
)

_CLAMP = """static double clamp(double v, double low, double high)
{
    v = (v < low) ? low : v;
    return (v > high) ? high : v;
}

"""


# `elementary.exp` and the sigmoid of `networks.table`, operation by operation: the same bits.
_SIGMOID = """static double sigmoid(double h)
{
    const double limited = clamp(-h, -700.0, 700.0);
    const double k = (limited * 1.4426950408889634 + 6755399441055744.0) - 6755399441055744.0;
    const double high = limited - k * 6.93147180369123816490e-01;
    const double low = k * 1.90821492927058770002e-10;
    const double r = high - low;
    const double z = r * r;
    const double c = r - z * (1.66666666666666019037e-01 + z * (-2.77777777770155933842e-03
        + z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
    return 1.0 / (1.0 + ldexp(1.0 - ((low - (r * c) / (2.0 - c)) - high), (int)k));
}

"""


def export_c(models: Sequence[Model], folder: str | Path) -> list[Path]:
    """Write a header and a source for each model.

    Parameters
    ----------
    models : sequence of Model
    folder : str or Path

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If two outputs give the same C name, or the folder cannot be written.
    """
    names = [c_name(model.output.name) for model in models]
    if len(set(names)) < len(names):
        raise InputError(f"outputs {[m.output.name for m in models]} give the C names {names}; they must differ")
    paths = []
    for name, model in zip(names, models, strict=True):
        for path, text in zip((f"{name}.h", f"{name}.c"), to_c(model, name=name), strict=True):
            paths.append(Path(folder) / path)
            write_text(paths[-1], text)
    return paths


def c_name(name: str) -> str:
    """A C identifier that resembles `name`."""
    text = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"{text}_" if text in _KEYWORDS else text if re.match(r"[A-Za-z]", text) else f"m_{text}"


def to_c(model: Model, *, name: str) -> tuple[str, str]:
    """Header and source of the function ``double name(const double x[])`` that evaluates `model`."""
    low, high = model.domain().T
    doc = [f" * {name}: {model.output} from"]
    for i, variable in enumerate(model.inputs):
        doc.append(f" *   x[{i}]  {variable}, domain {_number(low[i])} to {_number(high[i])}")
    doc.append(" * Inputs outside the domain are moved to its border.")
    comment = "\n".join(["/*", *(line.replace("*/", "* /") for line in doc), " */"])
    n = len(model.inputs)
    header = f"""{comment}
#ifndef {name.upper()}_H
#define {name.upper()}_H

#define {name.upper()}_N_INPUTS {n}

#ifdef __cplusplus
extern "C" {{
#endif

double {name}(const double x[{n}]);

#ifdef __cplusplus
}}
#endif

#endif
"""
    sigmoids = any(node.kind == SIGMOID for network in model.networks for node in network.nodes)
    clamp = (_CLAMP if _clamps(model) else "") + (_SIGMOID if sigmoids else "")
    include = f'#include "{name}.h"\n' + ("\n#include <math.h>\n" if sigmoids else "")
    functions = [
        _function(f"{name}_{k}", network, where)
        for k, (network, where) in enumerate(zip(model.networks, model.region_names(), strict=True))
    ]
    source = f"""{comment}
{include}
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

{clamp}{chr(10).join(functions)}
double {name}(const double x[{n}])
{{
{chr(10).join(_choice(model.partition, name))}
}}
"""
    return header, source


def _bounded(network: Network) -> bool:
    return (network.y_low, network.y_high) != (-UNBOUNDED, UNBOUNDED)


def _clamps(model: Model) -> bool:
    """Whether any function needs the clamp; an unused one is a warning."""
    return any(network.nodes or _bounded(network) for network in model.networks)


def _function(name: str, network: Network, where: str) -> str:
    lines = [f"/* {where} */", f"static double {name}(const double x[{network.n_inputs}])", "{"]
    used = {slot for node in network.nodes for slot in node.inputs}
    names = []
    for i in range(network.n_inputs):
        names.append(f"n{i}")
        if i in used:
            limits = f"{_number(network.x_low[i])}, {_number(network.x_high[i])}"
            gain = _number(1.0 / network.x_scale[i])
            lines.append(f"    const double n{i} = (clamp(x[{i}], {limits}) - {_number(network.x_mean[i])}) * {gain};")
    for number, node in enumerate(network.nodes):
        lines.append(f"    const double z{number} = {_polynomial(node, names)}; /* {KIND_NAMES[node.kind]} */")
        names.append(f"z{number}")
    if not used:
        lines.append("    (void)x;")
    y = _number(network.y_mean)
    if network.nodes:
        y = f"{y} + {_number(network.y_scale)} * {names[-1]}"
    if _bounded(network):
        y = f"clamp({y}, {_number(network.y_low)}, {_number(network.y_high)})"
    lines.append(f"    return {y};")
    return "\n".join([*lines, "}", ""])


def _polynomial(node: Node, names: Sequence[str]) -> str:
    c = [_number(value) for value in node.coef]
    v = [names[slot] for slot in node.inputs]
    if node.kind == LINEAR:
        return " + ".join(f"{a} * {b}" for a, b in zip(c, v, strict=True))
    if node.kind == SIGMOID:
        return f"sigmoid({' + '.join([c[0], *(f'{a} * {b}' for a, b in zip(c[1:], v, strict=True))])})"
    if node.kind == SINGLE:
        a = v[0]
        return f"{c[0]} + {a} * ({c[1]} + {a} * ({c[2]} + {a} * {c[3]}))"
    if node.kind == DOUBLE:
        a, b = v
        return (
            f"{c[0]} + {a} * ({c[1]} + {a} * ({c[3]} + {a} * {c[6]}) + {b} * {c[5]})"
            f" + {b} * ({c[2]} + {b} * ({c[4]} + {b} * {c[7]}))"
        )
    a, b, d = v
    return (
        f"{c[0]} + {a} * ({c[1]} + {a} * ({c[4]} + {a} * {c[11]}) + {b} * ({c[7]} + {d} * {c[10]}) + {d} * {c[8]})"
        f" + {b} * ({c[2]} + {b} * ({c[5]} + {b} * {c[12]}) + {d} * {c[9]})"
        f" + {d} * ({c[3]} + {d} * ({c[6]} + {d} * {c[13]}))"
    )


def _choice(partition: Partition, name: str, indent: str = "    ") -> list[str]:
    if not isinstance(partition, Split):
        return [f"{indent}return {name}_{partition}(x);"]
    deeper = indent + "    "
    return [
        f"{indent}if (x[{partition.axis}] > {_number(partition.at)}) {{",
        *_choice(partition.above, name, deeper),
        f"{indent}}} else {{",
        *_choice(partition.below, name, deeper),
        f"{indent}}}",
    ]


def _number(value: float) -> str:
    text = repr(float(value))
    text = text if any(mark in text for mark in ".en") else f"{text}.0"
    return f"({text})" if value < 0.0 else text
