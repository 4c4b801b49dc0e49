"""Commands of networks: fit, check, export, verify."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from polydraulic.cli.application import (
    METRIC,
    UnitsOption,
    app,
    check_endings,
    joined,
    keep_fit,
    say_self_test,
    say_written,
    values_by_name,
)
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar

if TYPE_CHECKING:
    from polydraulic.identification.dynamic_fit import DynamicFit
    from polydraulic.identification.table_fit import TableFit


@app.command()
def fit(
    table: Annotated[
        list[str],
        typer.Argument(
            help="CSV or Parquet table; any numbers, no hydraulics needed. Several tables, or a pattern in quotes, are learnt from together."
        ),
    ],
    inputs: Annotated[list[str], typer.Option(help="Input columns, separated by commas.")],
    outputs: Annotated[list[str], typer.Option(help="Output columns, separated by commas; one model each.")],
    out: Annotated[Path, typer.Option(help="Model file to write, .json.")],
    edges: Annotated[
        list[str] | None,
        typer.Option(
            help="Regions: COLUMN=EDGE,EDGE,... in the unit of the table, or with one: 'COLUMN=5,10 mm'; repeat for more."
        ),
    ] = None,
    regions: Annotated[
        int, typer.Option(help="Without edges: find regions in the data, at most this many; 1 for a single network.")
    ] = 1,
    layers: Annotated[
        int | None, typer.Option(help="Most layers; 4 if not given, for a dynamic model as chosen.")
    ] = None,
    cpm: Annotated[float | None, typer.Option(help="Complexity penalty multiplier; 1 if not given.")] = None,
    prior: Annotated[
        str | None,
        typer.Option(help="Prior error variance: adaptive, half-variance, or a number; adaptive if not given."),
    ] = None,
    bounds: Annotated[
        list[str] | None,
        typer.Option(
            help="Physical bounds of the output: LOW,HIGH, as for --edges; the data's range widened by a tenth if not given."
        ),
    ] = None,
    card: Annotated[
        Path | None, typer.Option(help="Model card to write, .html: data, errors, intervals, proofs, equations.")
    ] = None,
    deadbands: Annotated[
        bool, typer.Option("--deadbands", help="Also split regions at the deadbands that an imported log shows.")
    ] = False,
    dynamic: Annotated[
        bool,
        typer.Option(
            "--dynamic",
            help="Predict from earlier rows: one model of all outputs, which can run on its own predictions.",
        ),
    ] = False,
    longest_lag: Annotated[
        int | None, typer.Option(help="With --dynamic: how many rows ago may be read, at most; 8 if not given.", min=1)
    ] = None,
    boxes: Annotated[
        int, typer.Option(help="With --card: sub-boxes per region that its proofs may take.", min=1)
    ] = 200,
    units: UnitsOption = METRIC,
) -> None:
    """Learn polynomial networks from a table.

    A fifth of the rows is held out to state the error: blocks of time where the table has a column `time`, every fifth row
    elsewhere. The model is then fitted on all rows, in the same regions.

    With `--dynamic` the table is a log (columns `time`, `segment`, as `polydraulic import` writes it). The model predicts the next row from
    rows before it, or runs on its own predictions; lags and complexity are chosen by runs, and the errors of both are stated.

    Example: `polydraulic fit boom.parquet --inputs boom.travel,boom.p_in --outputs boom.q_in --out q_in.json --edges "boom.travel=4.8,9.6 mm"`

    - From a log, with all that an engineer asks before trusting a model: `polydraulic fit log.parquet --inputs boom.spool,boom.p_in
    --outputs boom.q_in --regions 12 --out q_in.json --card q_in.html`; `polydraulic check q_in.json --data new.parquet` later
    says whether it still holds.

    - From several days: `polydraulic fit monday.parquet tuesday.parquet --inputs boom.spool,boom.p_in --outputs boom.q_in --out q_in.json`

    - With memory: `polydraulic fit log.parquet --inputs valve --outputs pressure --dynamic --out pressure.json --card pressure.html`;
    `polydraulic run pressure.json log.parquet --plot run.svg` shows it running.

    What comes next: `polydraulic check` proves where the outputs can go and judges the model by new data, `polydraulic export` writes it
    as C code, FMU or ONNX.
    """
    from polydraulic.identification.dynamic_fit import fit_dynamic
    from polydraulic.identification.table_fit import fit_table
    from polydraulic.networks.growth.regressor import AbductiveRegressor

    check_endings(out, card)
    names, targets = names_in(inputs, "--inputs"), names_in(outputs, "--outputs")
    settings: dict[str, Any] = {} if layers is None else {"max_layers": layers}
    settings |= {} if cpm is None else {"cpm": cpm}
    if prior is not None:
        words = prior in ("adaptive", "half-variance")
        settings["prior_variance"] = prior if words else _prior(prior)
    limits = _ends(joined(bounds), "--bounds", partial(_units_of, table, targets)) if bounds else None
    borders = _edges(edges or [], table)
    if dynamic:
        given = {"--edges": borders, "--regions": regions != 1, "--bounds": limits, "--deadbands": deadbands}
        if static := [option for option in given if given[option]]:
            raise InputError(
                f"{static[0]} goes with static models; a dynamic one has a single region and the data's range"
            )
    elif longest_lag is not None:
        raise InputError("--longest-lag goes with --dynamic")
    if limits is not None:
        settings["output_bounds"] = limits
    estimator = AbductiveRegressor(**settings) if settings else None
    found: TableFit | DynamicFit
    with progress_bar("fit") as progress:
        if dynamic:
            found = fit_dynamic(
                table, names, targets, estimator=estimator, longest_lag=longest_lag or 8, progress=progress
            )
        else:
            found = fit_table(
                table, names, targets, edges=borders, max_regions=regions, deadbands=deadbands, estimator=estimator,
                progress=progress,
            )  # fmt: skip
        keep_fit(found, out, card, boxes=boxes, units=units, progress=progress)
    print(found.text(units))
    say_written(out, card)


@app.command()
def check(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    tables: Annotated[list[str] | None, typer.Argument(help="Further tables of --data.")] = None,
    within: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            help="LOW,HIGH: prove that no output can leave this range, or show where one does; in the unit of the model file, or with a unit: '0,170 l/min'.",
        ),
    ] = None,
    box: Annotated[
        list[str] | None,
        typer.Option(
            help="COLUMN=LOW,HIGH: only in this part of the inputs; repeat for more. The domain if not given. Units as for --range."
        ),
    ] = None,
    boxes: Annotated[int, typer.Option(help="Sub-boxes per region that the proof may take.", min=1)] = 20000,
    data: Annotated[
        list[str] | None, typer.Option(help="Table that the model has not seen: does the model still hold there?")
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Prove where the outputs of a model can go, anywhere in its domain or a box; or judge the model by new data.

    Prints a range that each output cannot leave, and the ranges of its slopes by region: a proof, not a sample. With `--range`, says
    whether the outputs stay in that range, or where one leaves it; the exit code is 1 unless it is proved that they stay.

    With `--data`, judges the model by new measurements next to what was stated when it was fitted; the exit code is 1 if it
    no longer holds. Dynamic models run on their own through the new log, restarted as often as when they were fitted.

    Example: `polydraulic check q_in.json --range "0,170 l/min"`

    - A year later: `polydraulic check q_in.json --data this_year.parquet`, or `--data spring.parquet autumn.parquet`

    What comes next: a model that no longer holds is fitted again, with the new rows; `polydraulic export` writes one that does.
    """
    from polydraulic.identification.model_check import check_models
    from polydraulic.networks.model.model_file import load_models

    if tables and not data:
        raise InputError(f"{tables[0]}: a model is judged by tables that follow --data")
    if data and (within or box):
        raise InputError("--data judges a model by measurements; --range and --box go with a proof")
    models = load_models(model)
    outputs = dict.fromkeys(found.output.unit for found in models)
    limits = _ends(joined(within), "--range", partial(list, outputs)) if within else None
    read = {variable.name: variable.unit for found in models for variable in found.inputs}
    with progress_bar("check") as progress:
        found = check_models(
            models,
            data=[*data, *(tables or [])] if data else None,
            limits=limits,
            box=_box(box or [], read),
            max_boxes=boxes,
            units=units,
            progress=progress,
        )
    print(found)
    if not found.holds:
        raise typer.Exit(1)


@app.command()
def export(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    out: Annotated[Path, typer.Option(help="Folder to write to, or a file with the ending of the target.")],
    to: Annotated[str, typer.Option(help="c, fmi2, fmi3, onnx, python, sympy or latex.")] = "c",
    name: Annotated[
        str | None,
        typer.Option(
            help="Name of the export; that of the file, of the only output or of the model file if not given."
        ),
    ] = None,
    real: Annotated[str, typer.Option(help="Precision of c and onnx: double or float.")] = "double",
    cross: Annotated[
        bool, typer.Option("--cross", help="FMUs also for Windows, macOS and arm64, using the package ziglang.")
    ] = False,
) -> None:
    """Write a model, with all its outputs, for use without this package: C, FMU, ONNX, Python, SymPy, LaTeX.

    Example: `polydraulic export q_in.json --to fmi3 --out q_in.fmu`

    - C99, outputs with exact slopes: `polydraulic export q_in.json --to c --out c`

    - For a controller without double precision: `polydraulic export q_in.json --to c --real float --out c`; how far it can be from
    double precision at most is proved, and stands in the header; that may take half a minute an output.

    What comes next: `polydraulic verify` compares all of these with the package.
    """
    from polydraulic.export.targets import export_models, is_file
    from polydraulic.networks.model.model_file import load_models

    models = load_models(model)
    if name is None and len(models) > 1 and not is_file(to, out):
        name = model.stem
    with progress_bar("export") as progress:
        progress(f"{to} to {out}", 0, 1)
        written = export_models(models, to, out, name=name, real=real, cross=cross, progress=progress)
    print(written)
    if to == "c":
        _, source, *run = written.files
        say_self_test(source)
        if run and real == "double":
            say_self_test(run[1], source)


@app.command()
def verify(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    points: Annotated[int, typer.Option(help="Points, inside the domain, on borders and outside.", min=6)] = 3000,
    seed: Annotated[int, typer.Option(help="Seed of the random points.", min=0)] = 0,
    prove: Annotated[
        bool | None,
        typer.Option(help="Hold C in single precision to what is proved of it; by default, of up to 16 networks."),
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Export a model to every target that can be built here, and compare them with the package at thousands of points.

    Dynamic models run row by row besides, as C and, where rows have a raster, as FMUs.

    Prints the largest difference of every output in its unit, of slopes and of the domain, what was not tried, and in the last line
    whether all is well. The exit code is 1 if a target of double precision does not agree to rounding, or C in single precision not within what is proved of it.

    Example: `polydraulic verify q_in.json`

    What comes next: `polydraulic export q_in.json --to fmi3 --out q_in.fmu`, with what was verified.
    """
    from polydraulic.export.verify import agreement_table, verify_models
    from polydraulic.networks.model.lag_words import dynamic_notes
    from polydraulic.networks.model.model_file import load_models

    models = load_models(model)
    with progress_bar("verify") as progress:
        found, not_tried = verify_models(models, n=points, seed=seed, prove=prove, progress=progress)
    print(agreement_table(found, not_tried, units))
    for note in dynamic_notes(models):
        print(f"note: {note}")
    if not all(agreement.holds for agreement in found):
        raise typer.Exit(1)


def names_in(texts: list[str], option: str) -> list[str]:
    """Column names that an option holds, given once or several times."""
    text = joined(texts)
    names = [name.strip() for name in text.split(",")]
    if not all(names) or len(set(names)) < len(names):
        raise InputError(f"{option} {text!r}: must be different column names separated by commas")
    return names


def _prior(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"--prior {text!r}: must be adaptive, half-variance, or a number") from None


def _numbers(text: str, option: str, count: int | None = None) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if not values or (count is not None and len(values) != count):
        raise InputError(
            f"{option} {text!r}: must be {'some' if count is None else count} number(s) separated by commas"
        )
    return values


def _in_unit(text: str, option: str, own: Callable[[], list[str]], count: int | None = None) -> list[float]:
    """Numbers in a column's unit, which `own` finds, from numbers in it or from numbers with a unit of the same kind."""
    from polydraulic.units import from_si, si_unit, to_si

    numbers, comma, last = text.rpartition(",")
    number, _, unit = last.strip().partition(" ")
    try:
        values = _numbers(f"{numbers}{comma}{number}", option, count)
    except InputError as error:
        form = "LOW,HIGH" if count == 2 else "EDGE,EDGE,..."
        raise InputError(f"{option} {text!r}: must be {form}, with a unit behind the last number or none") from error
    if not unit:
        return values
    units = own()
    if len(units) > 1:
        raise InputError(f"{option} {text!r}: the outputs are in {units}; give numbers without a unit")
    if units[0] == unit:
        return values
    if not units[0] or si_unit(units[0]) != si_unit(unit):
        raise InputError(f"{option} {text!r}: is in {unit!r}, the column in {units[0]!r}; give a unit of that kind")
    return [from_si(to_si(value, unit), units[0]) for value in values]


def _ends(text: str, option: str, own: Callable[[], list[str]]) -> tuple[float, float]:
    low, high = _in_unit(text, option, own, 2)
    return low, high


def _units_of(tables: list[str], columns: list[str]) -> list[str]:
    """Units of columns, each once."""
    from polydraulic.identification.arguments import table_of

    of, _ = table_of(tables, columns)
    return list(dict.fromkeys(map(of.unit, columns)))


def _edges(texts: list[str], tables: list[str]) -> dict[str, list[float]]:
    return {
        name: _in_unit(cuts, f"--edges {name}", partial(_units_of, tables, [name]))
        for name, cuts in values_by_name(texts, "--edges").items()
    }


def _box(texts: list[str], read: dict[str, str]) -> dict[str, tuple[float, float]]:
    return {
        name: _ends(ends, f"--box {name}", partial(list, [read.get(name, "")]))
        for name, ends in values_by_name(texts, "--box").items()
    }
