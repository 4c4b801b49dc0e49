"""The command line: thin, and importing what a command needs only when it runs."""

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from polydraulic.errors import InputError, SimulationError
from polydraulic.terminal import counted, print_differences, stages, steps

if TYPE_CHECKING:
    import numpy as np

    from polydraulic.networks import Model
app = typer.Typer(
    help="Polynomial abductive networks and real-time simulation of mobile hydraulic machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)

FLOWS = "exact, iterative, stiff, tlm, polynomial, neural, lookup, or pressure (historical)."
ScenarioArgument = Annotated[
    str,
    typer.Argument(
        help="A scenario by name (single_05, single_08: boom alone; pulse, sine, step, task: three links), a TOML file, "
        "a recording (.csv or .parquet), or random:SEED, random:SEED:SECONDS."
    ),
]
MachineOption = Annotated[str, typer.Option(help="Parameter set by name, or a TOML file.")]


class Target(StrEnum):
    """What a model can be exported to."""

    C = "c"


def main() -> None:
    """Run the command line; what a user can mend is one line and exit code 2."""
    try:
        app()
    except (InputError, SimulationError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    except MemoryError:
        print("error: not enough memory: ask for fewer rows or a larger time step", file=sys.stderr)
        sys.exit(2)


@app.command()
def report(
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("report"),
    chapter: Annotated[list[int] | None, typer.Option(help="Only this chapter; repeat for more.")] = None,
    figure: Annotated[str | None, typer.Option(help="Only this figure, as an SVG with its data.")] = None,
    machine: MachineOption = "cat215b",
) -> None:
    """Reproduce the thesis: every table, figure and printed number next to ours, and what is possible today.

    Writes index.html and a page for each chapter (readable offline), figures, their data as CSV, and results.json. What has been
    computed stays in the folder's cache: a second run takes seconds, and one that was killed goes on.

    Example: `polydraulic report --chapter 4 --out report`

    - One figure alone: `polydraulic report --figure 5-19`
    """
    from polydraulic.parameters import load_machine
    from polydraulic.studies import write_figure, write_report

    if chapter and figure:
        raise InputError("--chapter and --figure exclude each other: a figure belongs to one chapter")
    plant = load_machine(machine)
    with stages("report") as progress:
        if figure:
            path = write_figure(plant, out, figure, progress=progress)
        else:
            rows = write_report(plant, out, chapters=chapter, progress=progress)
            path = out / "index.html"
    print(path if figure else f"{path}: {sum(row['thesis'] is not None for row in rows)} printed numbers next to ours")


@app.command()
def simulate(
    scenario: ScenarioArgument,
    flow: Annotated[str, typer.Option(help=FLOWS)] = "exact",
    model: Annotated[
        list[Path] | None, typer.Option(help="Model file for polynomial, neural or pressure; repeat for more.")
    ] = None,
    arrangement: Annotated[
        str | None, typer.Option(help="Of the package's polynomial networks: cascade (if not given) or direct.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Trajectory to write, .parquet or .csv (SI).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture to write, .svg, .png or .pdf.")] = None,
    dt: Annotated[float, typer.Option(help="Time step in s.")] = 0.005,
    raster: Annotated[
        float | None,
        typer.Option(help="Record every so many seconds, a whole number of steps; every step if not given."),
    ] = None,
    method: Annotated[
        str, typer.Option(help="semi-implicit, rk4, rosenbrock or reference; the last two choose their own steps.")
    ] = "semi-implicit",
    machine: MachineOption = "cat215b",
) -> None:
    """Simulate a scenario, and state how far it is from the exact flow.

    Example: `polydraulic simulate task --out task.parquet --plot task.svg`

    - The iteration that the closed form replaces: `polydraulic simulate step --flow iterative`

    - Networks of your own: `polydraulic simulate single_08 --flow polynomial --model q_in.json --plot run.svg`

    - What a real operator did, from a CSV file with the columns time [s], swing [V], boom [V], stick [V]:
    `polydraulic simulate recording.csv --raster 0.05 --out run.csv`

    - Ten minutes of a random operator: `polydraulic simulate random:42:600 --raster 0.1 --out run.parquet`

    `polydraulic scenarios` lists the scenarios that come with the package; `polydraulic animate` shows the linkage move.
    """
    from polydraulic.flow import build_flow
    from polydraulic.networks import load_models
    from polydraulic.parameters import load_machine, load_scenario
    from polydraulic.simulation import compare, plot_run
    from polydraulic.simulation import simulate as run
    from polydraulic.simulation.plot import picture_ending, save_figure
    from polydraulic.tables import table_ending, write_table

    if model and flow not in ("polynomial", "neural", "pressure"):
        raise InputError(f"--model goes with --flow polynomial, neural or pressure, not with {flow!r}")
    if arrangement and (flow != "polynomial" or model):
        raise InputError("--arrangement goes with --flow polynomial and the package's own networks")
    if out is not None:
        table_ending(out)
    if plot is not None:
        picture_ending(plot)
    plant, what = load_machine(machine), load_scenario(scenario)
    options: dict[str, Any] = {"arrangement": arrangement} if arrangement else {}
    options |= {"models": [found for path in model for found in load_models(path)]} if model else {}
    chosen = build_flow(flow, plant, **options)
    runs = {}
    with steps("simulate", 1 if flow == "exact" else 2) as progress:
        if flow != "exact":
            progress("exact")
            runs["exact"] = run(plant, "exact", what, dt=dt, raster=raster, method=method)
        progress(flow)
        runs[flow] = run(plant, chosen, what, dt=dt, raster=raster, method=method)
    info = runs[flow].info
    print(f"{what.name}: {what.title}")
    if "rtol" in info:
        print(f"{method} with flow {flow!r} to a relative tolerance of {info['rtol']:g}, every {dt:g} s")
    else:
        print(
            f"{info['steps']} steps of {dt:g} s with flow {flow!r}; {info['steps_not_converged']} not converged, "
            f"{info['steps_out_of_domain']} outside the model's domain"
        )
    if flow != "exact":
        print_differences(compare(runs["exact"], runs[flow]))
    if out is not None:
        write_table(runs[flow], out)
    if plot is not None:
        save_figure(plot_run(runs), plot)


@app.command()
def animate(
    scenario: ScenarioArgument,
    out: Annotated[Path, typer.Option(help="Animation to write: .html plays in any browser, .gif anywhere.")],
    flow: Annotated[
        list[str] | None, typer.Option(help=f"{FLOWS} Repeat to lay runs on top of each other; exact if not given.")
    ] = None,
    dt: Annotated[float, typer.Option(help="Time step in s.")] = 0.005,
    rate: Annotated[
        float | None, typer.Option(help="Frames in a second; 20 for .html, which draws between them, 12.5 for .gif.")
    ] = None,
    machine: MachineOption = "cat215b",
) -> None:
    """Show the linkage move: side view, view from above, angles, flows and pressures.

    Example: `polydraulic animate task --flow exact --flow iterative --out task.html`

    - As a GIF: `polydraulic animate step --out step.gif`

    - A random operator: `polydraulic animate random:42:30 --out operator.html`

    The first flow is drawn filled, the others as outlines; distances of the tip are from the first.
    """
    from polydraulic.parameters import load_machine, load_scenario
    from polydraulic.simulation import simulate as run
    from polydraulic.simulation import write_animation
    from polydraulic.simulation.animation import animation_ending

    animation_ending(out)
    plant, what = load_machine(machine), load_scenario(scenario)
    flows = list(dict.fromkeys(flow or ["exact"]))
    runs = {}
    with steps("simulate", len(flows)) as progress:
        for name in flows:
            progress(name)
            runs[name] = run(plant, name, what, dt=dt)
    with counted("draw") as drawn:
        write_animation(runs, plant, out, rate=rate, progress=drawn)
    print(f"{out}: {what.name}, {', '.join(flows)}")


@app.command()
def scenarios() -> None:
    """List the scenarios that come with the package.

    Example: `polydraulic scenarios`
    """
    from polydraulic.parameters import LINKS, load_scenario, scenario_names

    for name in scenario_names():
        what = load_scenario(name)
        moved = ", ".join(link for link in LINKS if link not in what.locked)
        print(f"{name:12s} {what.duration:5g} s  {moved:20s} {what.title}")
    print(
        f"{'random:SEED':12s} {60:5g} s  {', '.join(LINKS):20s} Random operator; random:SEED:SECONDS for another duration"
    )


@app.command()
def sample(
    rows: Annotated[int, typer.Option(help="Number of rows.")],
    out: Annotated[Path, typer.Option(help="Table to write, .parquet or .csv (SI).")],
    circuit: Annotated[str, typer.Option(help="Circuit to sample: boom.")] = "boom",
    seed: Annotated[int, typer.Option(help="Seed of the random points.", min=0)] = 0,
    relief: Annotated[bool, typer.Option(help="With the pump's relief valve, or the ideal circuit without.")] = True,
    machine: MachineOption = "cat215b",
) -> None:
    """Evaluate a circuit at random points: a training database.

    Example: `polydraulic sample --circuit boom --rows 10000 --out boom.parquet`
    """
    import numpy as np

    from polydraulic.parameters import load_machine
    from polydraulic.studies.database import CIRCUITS, sample_boom
    from polydraulic.tables import write_table

    if circuit not in CIRCUITS:
        raise InputError(f"unknown circuit {circuit!r}; choose one of {list(CIRCUITS)}")
    table = sample_boom(load_machine(machine), rows, rng=np.random.default_rng(seed), relief=relief)
    write_table(table, out)
    print(f"{out}: {rows} rows of {', '.join(table.names)}")


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
    layers: Annotated[int, typer.Option(help="Layers at most.")] = 4,
    cpm: Annotated[float, typer.Option(help="Complexity penalty multiplier.")] = 1.0,
    prior: Annotated[
        str, typer.Option(help="Prior error variance: adaptive, half-variance, or a number.")
    ] = "adaptive",
    bounds: Annotated[
        str | None,
        typer.Option(help="Physical bounds of the output: LOW,HIGH; the data's range and a tenth if not given."),
    ] = None,
) -> None:
    """Learn polynomial networks from a table.

    A fifth of the rows, every fifth one, is held out to state the error; the model is then fitted on all rows.

    Example: `polydraulic fit boom.parquet --inputs boom.travel,boom.p_in --outputs boom.q_in --out q_in.json --edges boom.travel=0.0047752,0.0095504`
    """
    from polydraulic.networks import AbductiveRegressor, save_models
    from polydraulic.studies.fit import fit_table
    from polydraulic.tables import read_table

    names, targets = _names(inputs, "--inputs"), _names(outputs, "--outputs")
    data = read_table(table, [*names, *targets])
    limits = None if bounds is None else _numbers(bounds, "--bounds", 2)
    estimator = AbductiveRegressor(
        max_layers=layers,
        cpm=cpm,
        prior_variance=prior if prior in ("adaptive", "half-variance") else _numbers(prior, "--prior", 1)[0],
        output_bounds="data" if limits is None else (limits[0], limits[1]),
    )
    with steps("fit", 2 * len(targets)) as progress:
        fits = fit_table(data, names, targets, estimator, _edges(edges or []), regions, progress)
    save_models([found.model for found in fits], out)
    for found in fits:
        print(
            f"{found.model.output}: {len(found.model.networks)} network(s), {found.model.n_coefficients} coefficients; "
            f"held-out R2 {found.r2:.4f}, rms {found.rms:.4g}, largest {found.largest:.4g}"
        )


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
) -> None:
    """Prove where the outputs of a model can go, anywhere in its domain or a box: a proof, not a sample.

    Prints the proved range and the ranges of the slopes by region. With `--range`, says whether the model stays in it, or
    where it leaves; the exit code is 1 unless it is proved to stay.

    Example: `polydraulic check q_in.json --range 0,0.0028`
    """
    from polydraulic.networks import check_range, load_models, model_bounds

    limits = None if within is None else _numbers(within, "--range", 2)
    proved = True
    for found in load_models(model):
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


@app.command()
def export(
    model: Annotated[Path, typer.Argument(help="Model file, as written by fit.")],
    out: Annotated[Path, typer.Option(help="Folder to write to.")],
    to: Annotated[Target, typer.Option(help="Target: c.")] = Target.C,
) -> None:
    """Write a model as C99: a header and a source for each output.

    Example: `polydraulic export q_in.json --to c --out c`
    """
    from polydraulic.export import export_c
    from polydraulic.networks import load_models

    for path in export_c(load_models(model), out):
        print(path)


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


if __name__ == "__main__":
    main()
