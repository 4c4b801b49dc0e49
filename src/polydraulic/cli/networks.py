"""Commands of networks: fit, check, export, verify."""

from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from polydraulic.cli.app import METRIC, UnitsOption, app
from polydraulic.cli.dynamic import say_how_dynamic
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar

if TYPE_CHECKING:
    import numpy as np

    from polydraulic.networks.model.model import Model


@app.command()
def fit(
    table: Annotated[Path, typer.Argument(help="CSV or Parquet table; any numbers, no hydraulics needed.")],
    inputs: Annotated[str, typer.Option(help="Input columns, separated by commas.")],
    outputs: Annotated[str, typer.Option(help="Output columns, separated by commas; one model each.")],
    out: Annotated[Path, typer.Option(help="Model file to write, .json.")],
    edges: Annotated[
        list[str] | None,
        typer.Option(help="Regions: COLUMN=EDGE,EDGE,... in the column's unit, as in the table; repeat for more."),
    ] = None,
    regions: Annotated[
        int, typer.Option(help="Without edges: find regions in the data, this many at most; 1 for a single network.")
    ] = 1,
    layers: Annotated[
        int | None, typer.Option(help="Layers at most; 4 if not given, of a dynamic model as chosen.")
    ] = None,
    cpm: Annotated[float | None, typer.Option(help="Complexity penalty multiplier; 1 if not given.")] = None,
    prior: Annotated[
        str | None,
        typer.Option(help="Prior error variance: adaptive, half-variance, or a number; adaptive if not given."),
    ] = None,
    bounds: Annotated[
        str | None,
        typer.Option(help="Physical bounds of the output: LOW,HIGH; the data's range and a tenth if not given."),
    ] = None,
    card: Annotated[
        Path | None, typer.Option(help="Model card to write, .html: data, errors, intervals, proofs, equations.")
    ] = None,
    deadbands: Annotated[
        bool, typer.Option("--deadbands", help="Regions from the deadbands that an imported log shows, as well.")
    ] = False,
    dynamic: Annotated[
        bool,
        typer.Option("--dynamic", help="From rows before: one model of all outputs, which can run on its own answers."),
    ] = False,
    longest_lag: Annotated[
        int | None, typer.Option(help="With --dynamic: how many rows ago may be read, at most; 8 if not given.", min=1)
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Learn polynomial networks from a table.

    A fifth of the rows is held out to state the error: blocks of time where the table has a column `time`, every fifth row
    elsewhere. The model is then fitted on all rows.

    With `--dynamic` the table is a log (columns `time`, `segment`, as `polydraulic import` writes it). The model predicts the next row from
    rows before it, or runs on its own answers; lags and complexity are chosen by runs, and the errors of both are stated.

    Example: `polydraulic fit boom.parquet --inputs boom.travel,boom.p_in --outputs boom.q_in --out q_in.json --edges boom.travel=0.0047752,0.0095504`

    - From a log, with all that an engineer asks before trusting it: `polydraulic fit log.parquet --inputs boom.spool,boom.p_in
    --outputs boom.q_in --regions 12 --out q_in.json --card q_in.html`; `polydraulic check q_in.json --data new.parquet` later
    says whether it still holds.

    - With memory: `polydraulic fit log.parquet --inputs valve --outputs pressure --dynamic --out pressure.json --card pressure.html`;
    `polydraulic run pressure.json log.parquet --plot run.svg` shows it running.

    What comes next: `polydraulic check` proves where the outputs can go and judges the model by new data, `polydraulic export` writes it
    as C code, FMU or ONNX.
    """
    from polydraulic.identification.model_card import write_card
    from polydraulic.identification.shown import shown_fit
    from polydraulic.identification.table_fit import fit_table, unit_after, with_deadbands
    from polydraulic.networks.growth.regressor import AbductiveRegressor
    from polydraulic.networks.model.model_file import save_models
    from polydraulic.tables import read_table

    names, targets = _names(inputs, "--inputs"), _names(outputs, "--outputs")
    if card is not None and card.suffix.lower() != ".html":
        raise InputError(f"{card}: a model card ends in .html")
    settings: dict[str, Any] = {} if layers is None else {"max_layers": layers}
    settings |= {} if cpm is None else {"cpm": cpm}
    if prior is not None:
        words = prior in ("adaptive", "half-variance")
        settings["prior_variance"] = prior if words else _numbers(prior, "--prior", 1)[0]
    limits = None if bounds is None else _numbers(bounds, "--bounds", 2)
    borders = _edges(edges or [])
    if dynamic:
        given = {"--edges": borders, "--regions": regions != 1, "--bounds": limits, "--deadbands": deadbands}
        _fit_dynamic(
            table, names, targets, out, card, settings, longest_lag or 8, [o for o in given if given[o]], units
        )
        return
    if longest_lag is not None:
        raise InputError("--longest-lag goes with --dynamic")
    data = read_table(table, [*names, *targets], optional=["time", "segment"])
    if deadbands:
        borders, statements = with_deadbands(borders, data, names, targets)
        print("\n".join(statements))
    estimator = AbductiveRegressor(**settings, output_bounds="data" if limits is None else (limits[0], limits[1]))
    with progress_bar("fit") as progress:
        begun, pieces = count(), 2 * len(targets) + 1
        fits = fit_table(
            data, names, targets, estimator, borders, regions, lambda what: progress(what, next(begun), pieces)
        )
        save_models([found.model for found in fits], out)
        if card is not None:
            progress("card: proofs and pictures", pieces - 1, pieces)
            write_card(fits, data, table.name, card, units=units)
    for found in (shown_fit(fit, units) for fit in fits):
        print(
            f"{found.model.output}: {len(found.model.networks)} network(s), {found.model.n_coefficients} coefficients; "
            f"held-out R2 {found.r2:.4f}, rms {found.rms:.4g}{unit_after(found.model.output)}, "
            f"largest {found.largest:.4g}{unit_after(found.model.output)}"
        )


def _fit_dynamic(
    table: Path, inputs: list[str], outputs: list[str], out: Path, card: Path | None, settings: dict[str, Any],
    longest_lag: int, given: list[str], units: str,
) -> None:  # fmt: skip
    """Fit one dynamic model of all outputs."""
    from polydraulic.identification.dynamic_fit import fit_log, statements
    from polydraulic.identification.model_card import write_card
    from polydraulic.identification.shown import shown_fit
    from polydraulic.networks.growth.regressor import AbductiveRegressor
    from polydraulic.networks.model.model_file import save_models
    from polydraulic.tables import read_table

    if given:
        raise InputError(f"{given[0]} goes with static models; a dynamic one has a single region and the data's range")
    data = read_table(table, [*inputs, *outputs], optional=["time", "segment"])
    estimator = AbductiveRegressor(**settings) if settings else None
    with progress_bar("fit") as progress:
        fits = fit_log(data, inputs, outputs, estimator, longest_lag, progress)
        save_models([found.model for found in fits], out)
        if card is not None:
            progress("card: proofs and pictures", 0, 1)
            write_card(fits, data, table.name, card, units=units)
    for found in (shown_fit(fit, units) for fit in fits):
        print(found.model.output)
        for statement in statements(found):
            print(f"  {statement}")


@app.command()
def check(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    within: Annotated[
        str | None,
        typer.Option(
            "--range",
            help="LOW,HIGH: is it proved that no output leaves this range? In the unit of the model file, or with a unit: '0,170 l/min'.",
        ),
    ] = None,
    box: Annotated[
        list[str] | None,
        typer.Option(
            help="COLUMN=LOW,HIGH: only in this part of the inputs; repeat for more. The domain if not given. Units as for --range."
        ),
    ] = None,
    boxes: Annotated[int, typer.Option(help="Sub-boxes a region that the proof may take.", min=1)] = 20000,
    data: Annotated[
        Path | None, typer.Option(help="Table that the model has not seen: does the model still hold there?")
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Prove where the outputs of a model can go, anywhere in its domain or a box: a proof, not a sample.

    Prints the proved range and the ranges of the slopes by region. With `--range`, says whether the model stays in it, or
    where it leaves; the exit code is 1 unless it is proved to stay.

    With `--data`, judges the model by new measurements next to what was stated when it was fitted; the exit code is 1 if it
    no longer holds. Dynamic models run on their own through the new log, begun anew as often as when they were fitted.

    Example: `polydraulic check q_in.json --range "0,170 l/min"`

    - A year later: `polydraulic check q_in.json --data this_year.parquet`

    What comes next: a model that does not hold any more is fitted again, with the new rows; `polydraulic export` writes one that does.
    """
    from polydraulic.identification.shown import said_of_bounds, said_of_range
    from polydraulic.networks.model.model_file import load_models
    from polydraulic.networks.proof.bounds import check_range, model_bounds

    if data is not None:
        if within is not None or box:
            raise InputError("--data judges a model by measurements; --range and --box go with a proof")
        _judge(load_models(model), data, units)
        return
    proved, models = True, load_models(model)
    limits = [None if within is None else _ends(within, "--range", found.output.unit) for found in models]
    places = [_box(box or [], found) for found in models]
    say_how_dynamic(models)
    for k, (found, place, ends) in enumerate(zip(models, places, limits, strict=True)):
        with progress_bar("check") as progress:
            progress(f"proof of {found.output.name}", k, len(models))
            answer = None if ends is None else check_range(found, ends[0], ends[1], place, max_boxes=boxes)
            bounds = model_bounds(found, place, max_boxes=boxes) if ends is None else None
        if answer is not None:
            print(said_of_range(found, answer, units))
            proved = proved and answer.holds is True
        if bounds is not None:
            print("\n".join(said_of_bounds(found, bounds, units)))
    if not proved:
        raise typer.Exit(1)


def _judge(models: "list[Model]", data: Path, units: str) -> None:
    """Say whether models hold on a table."""
    from polydraulic.display import shown_table
    from polydraulic.identification.machine_judging import as_judged
    from polydraulic.identification.shown import shown_model
    from polydraulic.identification.validity import run_validity, validity
    from polydraulic.tables import read_table

    with progress_bar("check") as progress:
        progress(f"read {data}", 0, 2)
        table, holds = read_table(data), True
        progress("errors on the new data", 1, 2)
        static, dynamic = ([model for model in models if (model.dynamics is None) == how] for how in (True, False))
        judged = [validity(shown_model(model, units), shown_table(as_judged(model, table), units)) for model in static]
        if dynamic:
            judged += run_validity([shown_model(model, units) for model in dynamic], shown_table(table, units))
    for model, found in zip([*static, *dynamic], judged, strict=True):
        read = shown_model(model, units)
        holds &= found.holds
        print(f"{read.output}: {'holds' if found.holds else 'does not hold any more'}")
        for statement in found.statements:
            print(f"  {statement}")
        for region in found.regions:
            if region["rows"]:
                sizes = f"rms {region['rms']:.4g}, largest {region['largest']:.4g}"
                print(f"    {region['region']}: {region['rows']} rows, {sizes}")
    if not holds:
        raise typer.Exit(1)


@app.command()
def export(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    out: Annotated[Path, typer.Option(help="Folder to write to, or a file with the ending of the target.")],
    to: Annotated[str, typer.Option(help="c, fmi2, fmi3, onnx, python, sympy or latex.")] = "c",
    name: Annotated[
        str | None, typer.Option(help="What it is called; the file, the one output, or the model file if not given.")
    ] = None,
    real: Annotated[str, typer.Option(help="Precision of c and onnx: double or float.")] = "double",
    cross: Annotated[
        bool, typer.Option("--cross", help="FMUs also for Windows, macOS and arm64, by the package ziglang.")
    ] = False,
) -> None:
    """Write a model, with all its outputs, for use without this package: C, FMU, ONNX, Python, SymPy, LaTeX.

    Example: `polydraulic export q_in.json --to fmi3 --out q_in.fmu`

    - C99, outputs with exact slopes: `polydraulic export q_in.json --to c --out c`

    - For a controller without double precision: `polydraulic export q_in.json --to c --real float --out c`

    What comes next: `polydraulic verify` compares all of these with the package.
    """
    from polydraulic.export.targets import export_models, is_file
    from polydraulic.networks.model.model_file import load_models

    models = load_models(model)
    if name is None and len(models) > 1 and not is_file(to, out):
        name = model.stem
    with progress_bar("export") as progress:
        progress(f"{to} to {out}", 0, 1)
        written = export_models(models, to, out, name=name, real=real, cross=cross)
    for path in written.paths:
        print(path)
    for note in written.notes:
        print(f"note: {note}")
    say_how_dynamic(models)


@app.command()
def verify(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    points: Annotated[int, typer.Option(help="Points, inside the domain, on borders and outside.", min=6)] = 3000,
    seed: Annotated[int, typer.Option(help="Seed of the random points.", min=0)] = 0,
) -> None:
    """Export a model to everything that can be built here, and compare with the package at thousands of points.

    Prints the largest difference of every output in its unit, of slopes and of the domain, and what was not tried. The exit
    code is 1 if a target of double precision does not agree to rounding.

    Example: `polydraulic verify q_in.json`

    What comes next: `polydraulic export q_in.json --to fmi3 --out q_in.fmu`, with what was verified.
    """
    from polydraulic.export.verify import agreement_table, verify_models
    from polydraulic.networks.model.model_file import load_models

    models = load_models(model)
    with progress_bar("verify") as progress:
        found, not_tried = verify_models(models, points, seed=seed, progress=progress)
    print(agreement_table(found, not_tried))
    say_how_dynamic(models)
    if not all(agreement.holds for agreement in found):
        raise typer.Exit(1)


def _names(text: str, option: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if not all(names) or len(set(names)) < len(names):
        raise InputError(f"{option} {text!r}: must be different column names separated by commas")
    return names


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


def _ends(text: str, option: str, unit: str) -> list[float]:
    """Two numbers in `unit`, from numbers in it or from numbers with a unit of the same kind."""
    from polydraulic.units import from_si, si_unit, to_si

    numbers, _, other = text.strip().partition(" ")
    found = _numbers(numbers, option, 2)
    if not other:
        return found
    if si_unit(other) != si_unit(unit):
        raise InputError(f"{option} {text!r}: is in {other!r}, the model in {unit!r}; give a unit of that kind")
    return [from_si(to_si(value, other), unit) for value in found]


def _edges(texts: list[str]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for text in texts:
        name, _, cuts = text.partition("=")
        found[name.strip()] = _numbers(cuts, f"--edges {name}")
    return found


def _box(texts: list[str], model: "Model") -> "np.ndarray":
    """The model's domain, with the ends that are given in their place."""
    names, found = [variable.name for variable in model.inputs], model.domain()
    for text in texts:
        name, _, ends = text.partition("=")
        if name.strip() not in names:
            raise InputError(f"--box {text!r}: the model of {model.output.name!r} reads {names}")
        place = names.index(name.strip())
        found[place] = _ends(ends, f"--box {name}", model.inputs[place].unit)
    return found
