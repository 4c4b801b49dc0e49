"""Commands of networks: fit, check, export, verify."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from polydraulic.cli.app import app
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
        typer.Option(help="Regions: COLUMN=EDGE,EDGE,... in the column's unit; repeat for more."),
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
    """
    from polydraulic.identification.model_card import write_card
    from polydraulic.identification.table_fit import fit_table, with_deadbands
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
        _fit_dynamic(table, names, targets, out, card, settings, longest_lag or 8, [o for o in given if given[o]])
        return
    if longest_lag is not None:
        raise InputError("--longest-lag goes with --dynamic")
    data = read_table(table, [*names, *targets], optional=["time", "segment"])
    if deadbands:
        borders, statements = with_deadbands(borders, data, names, targets)
        print("\n".join(statements))
    estimator = AbductiveRegressor(**settings, output_bounds="data" if limits is None else (limits[0], limits[1]))
    with progress_bar("fit") as progress:
        fits = fit_table(data, names, targets, estimator, borders, regions, progress)
    save_models([found.model for found in fits], out)
    if card is not None:
        write_card(fits, data, table.name, card)
    for found in fits:
        print(
            f"{found.model.output}: {len(found.model.networks)} network(s), {found.model.n_coefficients} coefficients; "
            f"held-out R2 {found.r2:.4f}, rms {found.rms:.4g}, largest {found.largest:.4g}"
        )


def _fit_dynamic(
    table: Path, inputs: list[str], outputs: list[str], out: Path, card: Path | None, settings: dict[str, Any],
    longest_lag: int, given: list[str],
) -> None:  # fmt: skip
    """Fit one dynamic model of all outputs."""
    from polydraulic.identification.dynamic_fit import fit_log, statements
    from polydraulic.identification.model_card import write_card
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
        write_card(fits, data, table.name, card)
    for found in fits:
        print(found.model.output)
        for statement in statements(found):
            print(f"  {statement}")


@app.command()
def check(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    within: Annotated[
        str | None,
        typer.Option("--range", help="LOW,HIGH: is it proved that no output leaves this range? In the output's unit."),
    ] = None,
    box: Annotated[
        list[str] | None,
        typer.Option(
            help="COLUMN=LOW,HIGH: only in this part of the inputs; repeat for more. The domain if not given."
        ),
    ] = None,
    boxes: Annotated[int, typer.Option(help="Sub-boxes a region that the proof may take.", min=1)] = 20000,
    data: Annotated[
        Path | None, typer.Option(help="Table that the model has not seen: does the model still hold there?")
    ] = None,
) -> None:
    """Prove where the outputs of a model can go, anywhere in its domain or a box: a proof, not a sample.

    Prints the proved range and the ranges of the slopes by region. With `--range`, says whether the model stays in it, or
    where it leaves; the exit code is 1 unless it is proved to stay.

    With `--data`, judges the model by new measurements next to what was stated when it was fitted; the exit code is 1 if it
    no longer holds. Dynamic models run on their own through the new log, begun anew as often as when they were fitted.

    Example: `polydraulic check q_in.json --range 0,0.0028`

    - A year later: `polydraulic check q_in.json --data this_year.parquet`
    """
    from polydraulic.networks.model.model_file import load_models
    from polydraulic.networks.proof.bounds import check_range, model_bounds

    if data is not None:
        if within is not None or box:
            raise InputError("--data judges a model by measurements; --range and --box go with a proof")
        _judge(load_models(model), data)
        return
    limits = None if within is None else _numbers(within, "--range", 2)
    proved, models = True, load_models(model)
    say_how_dynamic(models)
    for found in models:
        place = _box(box or [], found)
        if limits is not None:
            answer = check_range(found, limits[0], limits[1], place, max_boxes=boxes)
            print(answer)
            proved = proved and answer.holds is True
            continue
        bounds = model_bounds(found, place, max_boxes=boxes)
        print(f"{found.output}: proved range {bounds.low:.6g} to {bounds.high:.6g}")
        for name, region in zip(found.region_names(), bounds.regions, strict=True):
            if region is None:
                continue
            print(f"  {name}: {region.low:.6g} to {region.high:.6g}, slopes")
            for variable, (low, high) in zip(found.inputs, region.slopes, strict=True):
                print(f"    by {variable!s:28s} {low:12.5g} to {high:12.5g}")
    if not proved:
        raise typer.Exit(1)


def _judge(models: "list[Model]", data: Path) -> None:
    """Say whether models hold on a table."""
    from polydraulic.identification.machine_judging import as_judged
    from polydraulic.identification.validity import run_validity, validity
    from polydraulic.tables import read_table

    table, holds = read_table(data), True
    static, dynamic = ([model for model in models if (model.dynamics is None) == how] for how in (True, False))
    judged = [validity(model, as_judged(model, table)) for model in static]
    judged += run_validity(dynamic, table) if dynamic else []
    for model, found in zip([*static, *dynamic], judged, strict=True):
        holds &= found.holds
        print(f"{model.output}: {'holds' if found.holds else 'does not hold any more'}")
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

    `polydraulic verify` compares all of these with the package.
    """
    from polydraulic.export.targets import export_models, is_file
    from polydraulic.networks.model.model_file import load_models

    models = load_models(model)
    if name is None and len(models) > 1 and not is_file(to, out):
        name = model.stem
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
        found[names.index(name.strip())] = _numbers(ends, f"--box {name}", 2)
    return found
