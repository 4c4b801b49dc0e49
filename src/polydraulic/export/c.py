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
from polydraulic.networks.model import cell_name
from polydraulic.networks.nodes import DOUBLE, KIND_NAMES, LINEAR, SINGLE
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
    clamp = _CLAMP if _clamps(model) else ""
    functions = [
        _function(f"{name}_{k}", network, cell_name(model.edges, model.inputs, k))
        for k, network in enumerate(model.networks)
    ]
    source = f"""{comment}
#include "{name}.h"

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

{clamp}{chr(10).join(functions)}
double {name}(const double x[{n}])
{{
{_choice(model, name)}}}
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


def _choice(model: Model, name: str) -> str:
    if len(model.networks) == 1:
        return f"    return {name}_0(x);\n"
    lines, stride = ["    int region = 0;"], len(model.networks)
    for axis, cuts in model.edges.items():
        stride //= len(cuts) + 1
        lines += [f"    region += (x[{axis}] > {_number(cut)}) ? {stride} : 0;" for cut in cuts]
    lines.append("    switch (region) {")
    lines += [f"    case {k}:\n        return {name}_{k}(x);" for k in range(len(model.networks) - 1)]
    lines += [f"    default:\n        return {name}_{len(model.networks) - 1}(x);", "    }"]
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    text = repr(float(value))
    text = text if any(mark in text for mark in ".en") else f"{text}.0"
    return f"({text})" if value < 0.0 else text
