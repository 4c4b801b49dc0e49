"""Models as C99: one header and one source, no allocation, no input or output, no state; dynamic ones also as a run (`run`).

A few networks are straight-line code, more are tables (`answers`). Three functions: outputs; outputs with exact slopes; how far the inputs lie outside the domain. Each says what an input
that is not a number does. Behind a macro the source tests itself with numbers that the package computed.
"""

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.c.allowance import allowance_lines, model_allowance, prove_allowances
from polydraulic.export.c.answers import answering_code, form_lines, numbers_row, region_call, value_call
from polydraulic.export.c.run import run_note, run_of, run_texts
from polydraulic.export.c.text import FLOAT, REALS, Real, block_comment, inner_ends, literal, string
from polydraulic.export.exported import Exported
from polydraulic.export.model_bundle import Bundle, bundle
from polydraulic.files import write_texts
from polydraulic.networks.model.lag_words import dynamic_notes
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import SIGMOID
from polydraulic.progress import Progress, quiet

_VECTORS = 24
_WIDTH = 120


def export_c(
    models: Sequence[Model],
    folder: str | Path,
    *,
    name: str | None = None,
    real: str = "double",
    progress: Progress = quiet,
) -> Exported:
    """Write a header and a source for models.

    Parameters
    ----------
    models : sequence of Model
        One per output.
    folder : str or Path
    name : str, optional
        Name of the files and of their functions, made a C identifier; the output's if there is one model, else "model".
    real : str
        "double", with the bits of the package, or "float".
    progress : Progress, optional
        Told of which output it is being proved how far "float" can be off.

    Returns
    -------
    Exported
        Header and source; of dynamic models also those of a run row by row.

    Raises
    ------
    InputError
        If the models do not go together, a number or a value does not fit into a float, or the folder cannot be written.
    """
    whole = bundle(models, name=name)
    run = run_of(whole)
    if real == "float":
        prove_allowances(whole.models, progress)
    texts = dict(zip((f"{whole.name}.h", f"{whole.name}.c"), to_c(whole, real=real), strict=True))
    texts |= {} if run is None else run_texts(whole, run, REALS[real])
    files = {Path(folder) / file: text for file, text in texts.items()}
    write_texts(files)
    notes = dynamic_notes(models) if run is None else [run_note(whole.name)]
    proved = allowance_lines(models) if real == "float" else []
    return Exported(tuple(files), (*whole.name_notes(), *notes, *proved))


def to_c(whole: Bundle, *, real: str = "double", prove: bool = True) -> tuple[str, str]:
    """Header and source of C functions for models.

    Parameters
    ----------
    whole : Bundle
        Models and their common name, from `bundle`.
    real : str
        "double" or "float".
    prove : bool
        Whether the header of `float` code states what is proved of it.

    Returns
    -------
    header, source : str

    Raises
    ------
    InputError
        If `real` is neither, or a number or a value does not fit into a float.
    """
    if real not in REALS:
        raise InputError(f"real = {real!r}: must be one of {list(REALS)}")
    prove = prove and real == FLOAT.name
    return _header(whole, REALS[real], prove), _source(whole, REALS[real], prove)


def _header(whole: Bundle, real: Real, prove: bool) -> str:
    t, name, macro = real.name, whole.name, whole.name.upper()
    n, m = len(whole.inputs), len(whole.models)
    inputs, outputs = whole.identifiers()
    places = [f"#define {macro}_INPUT_{c.upper()} {i}" for i, c in enumerate(inputs)]
    places += [f"#define {macro}_OUTPUT_{c.upper()} {k}" for k, c in enumerate(outputs)]
    return f"""{block_comment([*_about(whole), *form_lines(whole), *(_proved(whole) if prove else [])])}
#ifndef {macro}_H
#define {macro}_H

#define {macro}_N_INPUTS {n}
#define {macro}_N_OUTPUTS {m}
{chr(10).join(places)}

/* What the functions return. */
#define {macro}_INSIDE 0
#define {macro}_OUTSIDE 1 /* an input lies outside of the domain of the network that answers (of its region), and was moved to its border */
#define {macro}_NOT_A_NUMBER 2 /* an input is not a number, and so are all outputs and slopes */

#ifdef __cplusplus
extern "C" {{
#endif

extern const char *const {name}_input_names[{n}];
extern const char *const {name}_input_units[{n}];
extern const char *const {name}_output_names[{m}];
extern const char *const {name}_output_units[{m}];
extern const {t} {name}_domain_low[{n}];
extern const {t} {name}_domain_high[{n}];

/* Outputs y at inputs x. */
int {name}(const {t} x[{n}], {t} y[{m}]);

/* Outputs, and slopes: dy_dx[{n} * k + i] is that of output k by input i. */
int {name}_slopes(const {t} x[{n}], {t} y[{m}], {t} dy_dx[{n * m}]);

/* How far x lies outside of the domain, as a share of its width: 0 inside, {real.largest} if an input is not a number.
   Its slopes are put into slopes. */
{t} {name}_outside(const {t} x[{n}], {t} slopes[{n}]);

#ifdef __cplusplus
}}
#endif

#endif
"""


def _about(whole: Bundle) -> list[str]:
    lines = [f"{whole.name}: {', '.join(map(str, whole.outputs))} from", ""]
    for i, (variable, (low, high)) in enumerate(zip(whole.inputs, whole.domain().tolist(), strict=True)):
        lines.append(f"  x[{i}]  {variable}, domain {low!r} to {high!r}")
    if len(whole.models) > 1:
        lines += ["", *(f"  y[{k}]  {variable}" for k, variable in enumerate(whole.outputs))]
    lines += ["", "Inputs outside of the domain are moved to its border."]
    if notes := dynamic_notes(whole.models):
        runs = (
            [f"Exported as C, {whole.name}_run.h stands beside it: the model row by row, which does all that."]
            if run_of(whole)
            else []
        )
        lines += ["", *(line for note in [*notes, *runs] for line in wrap(note, _WIDTH))]
    return lines


def _proved(whole: Bundle) -> list[str]:
    return [
        "",
        "Proved of this code, rounded to nearest, with fused multiply-adds or without, for any inputs that are numbers; the distance",
        "from double precision, exact or as the package computes it, is that at the same inputs in the domain:",
        *(f"  {line}" for line in allowance_lines(whole.models)),
    ]


def _source(whole: Bundle, real: Real, prove: bool) -> str:
    t, name, macro = real.name, whole.name, whole.name.upper()
    n, m = len(whole.inputs), len(whole.models)
    sigmoids = any(node.kind == SIGMOID for model in whole.models for net in model.networks for node in net.nodes)
    include = f'#include "{name}.h"\n\n#include <float.h>\n' + ("#include <math.h>\n" if sigmoids else "")
    low, high = np.array([inner_ends(low, high, real) for low, high in whole.domain().tolist()]).T
    constants = "\n".join(
        [f"const char *const {name}_{what}[{len(v)}] = {{{', '.join(map(string, v))}}};" for what, v in (
            ("input_names", [v.name for v in whole.inputs]), ("input_units", [v.unit for v in whole.inputs]),
            ("output_names", [v.name for v in whole.outputs]), ("output_units", [v.unit for v in whole.outputs]))]
        + [f"const {t} {name}_domain_{end}[{n}] = {numbers_row(v, real)};" for end, v in (("low", low), ("high", high))]
    )  # fmt: skip

    regions = [f"const int r{k} = {region_call(whole, k)};" for k in range(m)]
    outside = " | ".join(f"outside_{k}(x, r{k})" for k in range(m))

    def body(slopes: str | None, blank: str) -> str:
        calls = [value_call(whole, k, slopes and slopes.format(first=n * k)) for k in range(m)]
        return f"""    {f"{chr(10)}    ".join(regions)}
    const int outside = {outside};
    if ((outside != 0) && (not_a_number(x) != 0)) {{
        int k;
        for (k = 0; k < {m}; ++k) {{
            y[k] = {" + ".join(f"x[{i}]" for i in range(n))};
        }}
{blank}        return {macro}_NOT_A_NUMBER;
    }}
{chr(10).join(calls)}
    return (outside != 0) ? {macro}_OUTSIDE : {macro}_INSIDE;"""

    no_slopes = f"""        for (k = 0; k < {n * m}; ++k) {{
            dy_dx[k] = y[0];
        }}
"""
    return f"""{block_comment(_about(whole))}
{include}
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

{constants}

static int not_a_number(const {t} x[{n}])
{{
    return ({" || ".join(f"(x[{i}] != x[{i}])" for i in range(n))}) ? 1 : 0;
}}

{answering_code(whole, real)}
int {name}(const {t} x[{n}], {t} y[{m}])
{{
{body(None, "")}
}}

int {name}_slopes(const {t} x[{n}], {t} y[{m}], {t} dy_dx[{n * m}])
{{
{body("&dy_dx[{first}]", no_slopes)}
}}

{_outside(whole, real)}
{_self_test(whole, real, prove)}"""


def _outside(whole: Bundle, real: Real) -> str:
    t, name, n, zero = real.name, whole.name, len(whole.inputs), literal(0.0, real)
    parts = []
    for k, place in enumerate(whole.places):
        parts.append(f"""    r = {region_call(whole, k)};
    for (i = 0; i < {len(place)}; ++i) {{
        const {t} v = x[place_{k}[i]];
        const {t} share = share_{k}[r][i];
        const {t} below = (low_{k}[r][i] - v) * share;
        const {t} above = (v - high_{k}[r][i]) * share;
        if ((below > found) || (above > found)) {{
            found = (below > above) ? below : above;
            slope = (below > above) ? -share : share;
            at = place_{k}[i];
        }}
    }}""")
    return f"""{t} {name}_outside(const {t} x[{n}], {t} slopes[{n}])
{{
    {t} found = {zero};
    {t} slope = {zero};
    int at = 0;
    int r;
    int i;
    for (i = 0; i < {n}; ++i) {{
        slopes[i] = {zero};
    }}
    if (not_a_number(x) != 0) {{
        return {real.largest};
    }}
{chr(10).join(parts)}
    slopes[at] = slope;
    return found;
}}
"""


def _self_test(whole: Bundle, real: Real, prove: bool) -> str:
    """`main` behind a macro: 0, or the number of the first vector that fails."""
    t, name, macro = real.name, whole.name, whole.name.upper()
    n, m = len(whole.inputs), len(whole.models)
    X = whole.points(_VECTORS)
    if real is FLOAT:  # away from borders, on whose sides the roundings of both precisions may lie
        X = _smooth(whole, X).astype(np.float32).astype(np.float64)
    y, slopes, outside = whole.predict(X), whole.slopes(X).reshape(len(X), -1), whole.outside(X) > 0.0
    near_y, near_slopes = (real.digits * np.maximum(np.abs(v).max(axis=0), 1e-30) for v in (y, slopes))

    if prove:  # what is proved of it may be less than what is usual
        proved = [model_allowance(model).error for model in whole.models]
        near_y = np.maximum(near_y, np.where(np.isfinite(proved), proved, 0.0))

    def table(rows: np.ndarray) -> str:
        kept = np.where(np.abs(rows) < real.smallest, 0.0, rows)
        return ",\n    ".join(numbers_row(row, real) for row in kept)

    return f"""#ifdef {macro}_SELF_TEST
/* Numbers that the package computed. main returns 0, or the number of the first vector that fails. Names begin with own, for
   the functions above may have any other name. */
static const {t} own_test_x[{len(X)}][{n}] = {{
    {table(X)}
}};
static const {t} own_test_y[{len(X)}][{m}] = {{
    {table(y)}
}};
static const {t} own_test_slopes[{len(X)}][{n * m}] = {{
    {table(slopes)}
}};
static const int own_test_status[{len(X)}] = {{{", ".join(str(int(flag)) for flag in outside)}}};
static const {t} own_near_y[{m}] = {numbers_row(near_y, real)};
static const {t} own_near_slopes[{n * m}] = {numbers_row(near_slopes, real)};

static int own_differs({t} a, {t} b, {t} near)
{{
    return ((a - b <= near) && (b - a <= near)) ? 0 : 1;
}}

int main(void)
{{
    {t} own_x[{n}];
    {t} own_y[{m}];
    {t} own_z[{m}];
    {t} own_slopes[{n * m}];
    volatile {t} own_zero = {literal(0.0, real)};
    int own_v;
    int own_k;
    for (own_v = 0; own_v < {len(X)}; ++own_v) {{
        const {t} *own_at = own_test_x[own_v];
        const int own_status = own_test_status[own_v];
        int own_bad = ({name}(own_at, own_y) == own_status) ? 0 : 1;
        own_bad |= ({name}_slopes(own_at, own_z, own_slopes) == own_status) ? 0 : 1;
        own_bad |= ((({name}_outside(own_at, own_x) > {literal(0.0, real)}) ? 1 : 0) == own_status) ? 0 : 1;
        for (own_k = 0; own_k < {m}; ++own_k) {{
            own_bad |= own_differs(own_y[own_k], own_test_y[own_v][own_k], own_near_y[own_k]);
            own_bad |= own_differs(own_z[own_k], own_y[own_k], {literal(0.0, real)});
        }}
        for (own_k = 0; own_k < {n * m}; ++own_k) {{
            own_bad |= own_differs(own_slopes[own_k], own_test_slopes[own_v][own_k], own_near_slopes[own_k]);
        }}
        if (own_bad != 0) {{
            return own_v + 1;
        }}
    }}
    for (own_k = 0; own_k < {n}; ++own_k) {{
        own_x[own_k] = own_test_x[0][own_k];
    }}
    own_x[{n - 1}] = own_zero / own_zero;
    own_v = {name}(own_x, own_y);
    return ((own_v == {macro}_NOT_A_NUMBER) && (own_y[0] != own_y[0])) ? 0 : {len(X) + 1};
}}
#endif
"""


def _smooth(whole: Bundle, X: np.ndarray) -> np.ndarray:
    """Rows around which slopes and domain change little; all if there are none."""
    step = 1e-4 * np.ptp(whole.domain(), axis=1)
    around = [whole.slopes(X + sign * step) for sign in (-1.0, 1.0)]
    change = np.abs(around[1] - around[0]) <= 0.02 * np.abs(around[0]).max(axis=0)
    same = (whole.outside(X - step) > 0.0) == (whole.outside(X + step) > 0.0)
    good = change.reshape(len(X), -1).all(axis=1) & same
    return X[good] if good.any() else X
