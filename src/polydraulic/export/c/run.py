"""Dynamic models as C99 that runs row by row: lagged values in a ring, strengths of joints from measured rows, answers within their limits.

Two files besides those of the function of lagged values, ``NAME_run.h`` and ``NAME_run.c``. What a row does is the text of the package
(`networks.dynamic.rows`), so a run has its bits where the function has them.
"""

from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.c.text import DOUBLE, Real, block_comment, literal
from polydraulic.export.exported import filled
from polydraulic.export.model_bundle import Bundle
from polydraulic.export.names import unique_names
from polydraulic.export.translate.program import Program
from polydraulic.networks.dynamic.free_run import dynamics_of, limits_of, prepare_loop, run_windows, strengths_before
from polydraulic.networks.dynamic.joint_strength import strength_numbers
from polydraulic.networks.dynamic.rows import STATES, answer, begin_strength, see_row, strength_of
from polydraulic.networks.model.lag_words import change_in_words, lags_in_words, strength_in_words
from polydraulic.networks.model.lags import Lag
from polydraulic.networks.model.model import Variable

_WIDTH = 120
_ANSWERS = 25  # rows of the self-test that are answered; an exit code has room for their number, below 256
_WINDOWS = 2  # and windows of the slowest strength that are measured before
_PERIODS = (30.0, 90.0)  # rows, of the waves of its signals


class Run(NamedTuple):
    """What a run of models reads and keeps.

    Attributes
    ----------
    inputs : tuple of Variable
        Signals that are no outputs of the models, by name.
    outputs : tuple of Variable
    reads : tuple of (int, int)
        For each input of the bundle: which signal, outputs behind inputs, and how many rows ago.
    warm_up : int
        Rows before the first answer.
    raster : float or None
        Between rows, in s.
    strong : tuple of int
        Outputs of joints whose strength is followed.
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    reads: tuple[tuple[int, int], ...]
    warm_up: int
    raster: float | None
    strong: tuple[int, ...]


def run_of(whole: Bundle) -> Run | None:
    """What a run of models reads and keeps; None where one of them is static.

    Raises
    ------
    InputError
        One name for two lags, or models of different rasters.
    """
    if any(model.dynamics is None for model in whole.models):
        return None
    dynamics = [dynamics_of(model) for model in whole.models]
    rasters = {one.raster for one in dynamics}
    if len(rasters) > 1:
        raise InputError(f"the models go by rows {', '.join(sorted(map(str, rasters)))} s apart: export them apart")
    lags: dict[int, Lag] = {}
    for one, place in zip(dynamics, whole.places, strict=True):
        for i, lag in zip(place, one.lags, strict=True):
            if lags.setdefault(i, lag) != lag:
                raise InputError(
                    f"input {whole.inputs[i].name!r} is {lag} of one model and {lags[i]} of another: export them apart"
                )
    outputs = [variable.name for variable in whole.outputs]
    units = {lag.signal: whole.inputs[i].unit for i, lag in lags.items() if lag.signal not in outputs}
    names = [*sorted(units), *outputs]
    return Run(
        tuple(Variable(name, units[name]) for name in sorted(units)),
        whole.outputs,
        tuple((names.index(lags[i].signal), lags[i].steps) for i in range(len(whole.inputs))),
        max(one.warm_up for one in dynamics),
        rasters.pop(),
        tuple(k for k, one in enumerate(dynamics) if one.strength is not None),
    )


def run_note(name: str) -> str:
    """What an export that runs says of itself."""
    return (
        f"dynamic: {name}_run.h runs row by row as `polydraulic run` does, behind measured rows, strengths of joints included; {name}.h is the function of "
        "lagged values alone"
    )


def run_texts(whole: Bundle, run: Run, real: Real) -> dict[str, str]:
    """Header and source by file name.

    Parameters
    ----------
    whole : Bundle
        Of dynamic models.
    run : Run
    real : Real
        Precision of the function of lagged values; a run keeps its rows in double precision.
    """
    name, upper, n = whole.name, whole.name.upper(), len(run.inputs)
    limits = [limits_of(model) for model in whole.models]
    numbers = [strength_numbers(dynamics_of(model).strength) for model in whole.models]
    program = Program(
        [name, *(f"{name}_{word}" for word in ("run", "run_begin", "run_measured", "run_next", "run_strength"))]
    )
    states, one = np.zeros(STATES), 1.0
    for kernel, examples in (
        (answer, [limits[0], one, one, one, one]),
        (begin_strength, [states, numbers[0]]),
        (see_row, [states, limits[0], numbers[0], one, one, one]),
        (strength_of, [one, one]),
    ):
        program.entry(f"{name}_run_{kernel.__name__}", kernel, examples)
    places = [f"#define {upper}_RUN_INPUT_{c.upper()} {i}" for i, c in enumerate(unique_names([v.name for v in run.inputs]))]  # fmt: skip
    places += [f"#define {upper}_RUN_OUTPUT_{c.upper()} {k}" for k, c in enumerate(whole.identifiers()[1])]
    raster = "" if run.raster is None else f"#define {upper}_RUN_DT {literal(run.raster)} /* s between rows */\n"
    no_input = f"""    if (!{name}_run_finite(inputs, {n})) {{
        {name}_run_begin(r);
        return {upper}_RUN_NOT_A_NUMBER;
    }}
"""
    fill = {
        "name": name,
        "NAME": upper,
        "real": real.name,
        "about": block_comment(_about(whole, run, real)),
        "places": "\n".join(places),
        "n_inputs": str(n),
        "n_outputs": str(len(run.outputs)),
        "warm_up": str(run.warm_up),
        "n_kept": str(run.warm_up + 1),
        "raster": raster,
        "states": str(STATES),
        "const_inputs": f"const double inputs[{upper}_RUN_N_INPUTS], " if n else "",
        "finite_inputs": f"!{name}_run_finite(inputs, {n}) || " if n else "",
        "put_inputs": f"    memcpy(r->rows[r->at], inputs, {n} * sizeof(double));\n" if n else "",
        "check_inputs": no_input if n else "",
        "reads": _lines(run.reads),
        "limits": _lines(limits),
        "numbers": _lines(numbers),
        "structs": program.scope.structs(),
        "code": program.code(),
        "row": "row, " if n else "",
        "self_test": "",
    }
    if real is DOUBLE:
        found = filled("run_self_test", name, fill | _self_test(try_run(whole, run)), (".c",))
        fill["self_test"] = found[f"{name}.c"]
    texts = filled("run", name, fill)
    return {f"{name}_run{ending}": texts[f"{name}{ending}"] for ending in (".h", ".c")}


def _lines(rows: Iterable[Sequence[float]]) -> str:
    """Rows of numbers as members of an array."""
    texts = (", ".join(str(x) if isinstance(x, int) else literal(x) for x in row) for row in rows)
    return ",\n    ".join(f"{{{text}}}" for text in texts)


def _about(whole: Bundle, run: Run, real: Real) -> list[str]:
    """The comment at the top of the header."""
    name, upper = whole.name, whole.name.upper()
    lines = [f"{name}_run: {', '.join(map(str, run.outputs))}, row by row, from", ""]
    lines += [f"  inputs[{i}]  {variable}" for i, variable in enumerate(run.inputs)]
    lines += [f"  outputs[{k}]  {variable}" for k, variable in enumerate(run.outputs)]
    lines += [
        "",
        f"    static {name}_run r;",
        f"    {name}_run_begin(&r);",
        f"    every row that is measured: {name}_run_measured(&r, inputs, outputs);",
        f"    to look ahead: copy = r; {name}_run_next(&copy, inputs, outputs); and so on.",
        "",
    ]
    far = "as far apart as those of the log" if run.raster is None else f"{run.raster:g} s apart"
    texts = [
        "There is no hidden state: a copy of the struct is a copy of the run, which goes on by itself from what was measured. Rows are "
        f"{far}. {name}.c answers from lagged values; where the strength of a joint is followed, the change from the last row is multiplied by it, and "
        "kept within the largest change and the ends of the output.",
    ]
    for model in whole.models:
        dynamics = dynamics_of(model)
        told = f"{model.output} reads {lags_in_words(dynamics)}, and changes by {change_in_words(model.output, dynamics)} a row"
        if dynamics.strength is not None:
            told += f"; {strength_in_words(dynamics)}: windows of {dynamics.strength.rows} rows, before the first of which it is as strong as in the mean"
        texts.append(f"{told}.")
    same = "the bits of the package" if real is DOUBLE else "what the function in single precision makes of it"
    texts.append(f"Compiled without fused multiply-adds (gcc: -std=c99 or -ffp-contract=off) it gives {same}.")
    if real is DOUBLE:
        texts.append(f"With {upper}_RUN_SELF_TEST it has a main, which returns 0 where that is so.")
    return [*lines, *(line for text in texts for line in wrap(text, _WIDTH))]


class RunTrial(NamedTuple):
    """Rows that a run is tried with: waves of no machine, measured up to a row, and what the package answers from there on.

    Attributes
    ----------
    middle, half : (n_signal,) array
    rates : (n_signal,) array of int
        Of the waves, whose period is 65536.
    signals : (n_row, n_signal) array
        Inputs, then outputs.
    measured : int
    strengths : (n_output, 2) array
        Upwards and downwards, of the rows that are answered.
    answers : (n_row - measured, n_output) array
    """

    middle: np.ndarray
    half: np.ndarray
    rates: np.ndarray
    signals: np.ndarray
    measured: int
    strengths: np.ndarray
    answers: np.ndarray


def try_run(whole: Bundle, run: Run, n_answers: int = _ANSWERS) -> RunTrial:
    """Run the package on waves through the domain."""
    ranges = [_range(whole, run, column) for column in range(len(run.inputs) + len(run.outputs))]
    middle, half = np.array(ranges).T
    rates = np.round(65536.0 / np.linspace(*_PERIODS, len(ranges))).astype(np.int64)
    strengths = [dynamics_of(model).strength for model in whole.models]
    measured = run.warm_up + _WINDOWS * max((one.rows for one in strengths if one is not None), default=0)
    n_rows = measured + n_answers
    wave = np.abs(((np.arange(n_rows)[:, None] * rates) & 65535) / 32768.0 - 1.0)
    signals = middle + half * (2.0 * wave - 1.0)
    loop = prepare_loop(whole.models, [variable.name for variable in (*run.inputs, *run.outputs)])
    windows, since = [(measured, n_rows)], [run.warm_up]
    answers = run_windows(loop, signals, windows, since)[measured:]
    return RunTrial(middle, half, rates, signals, measured, strengths_before(loop, signals, windows, since)[0], answers)


def _self_test(trial: RunTrial) -> dict[str, str]:
    """What the self-test is filled with."""
    return {
        "middle": ", ".join(map(literal, trial.middle.tolist())),
        "half": ", ".join(map(literal, trial.half.tolist())),
        "rate": ", ".join(map(str, trial.rates.tolist())),
        "strength": _lines(trial.strengths.tolist()),
        "answers": _lines(trial.answers.tolist()),
        "n_answers": str(len(trial.answers)),
        "n_measured": str(trial.measured),
        "n_rows": str(len(trial.signals)),
    }


def _range(whole: Bundle, run: Run, column: int) -> tuple[float, float]:
    """Middle and half of what the networks know of a signal; of one that they do not read 0 and 1."""
    low, high = next((box for box, (c, _) in zip(whole.domain().tolist(), run.reads, strict=True) if c == column), (-1.0, 1.0))  # fmt: skip
    return 0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low
