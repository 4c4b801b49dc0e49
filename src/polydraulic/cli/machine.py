"""Commands of the machine: simulate, animate, scenarios, sample, train."""

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from polydraulic.cli.application import METRIC, FaultOption, MachineOption, UnitsOption, app
from polydraulic.errors import InputError
from polydraulic.terminal import print_differences, progress_bar


def _scenario_names() -> list[str]:
    from polydraulic.parameters.scenario import scenario_names

    return [*scenario_names(), "random:"]


def _flow_names() -> list[str]:
    from polydraulic.flow.dispatch import FLOW_KINDS

    return list(FLOW_KINDS)


FLOWS = "exact, iterative, stiff, tlm, polynomial, polynomial-fine, neural, lookup, residual, or pressure (historical)."
OwnMachineOption = Annotated[
    str | None,
    typer.Option(help="Machine by name, or a TOML file; if not given, the one that the scenario is for, else cat215b."),
]
ScenarioArgument = Annotated[
    str,
    typer.Argument(
        help="A scenario by name (single_05, single_08: boom alone; pulse, sine, step, task: three links; cat215b_bucket_dig, cat215b_crossover_dig, "
        "excavator_22t_dig, loader_crane_lift, wheel_loader_cycle: those machines), a TOML file, "
        "a recording (.csv or .parquet), or random:SEED, random:SEED:SECONDS, random:SEED:SECONDS:VOLTS.",
        autocompletion=_scenario_names,
    ),
]


@app.command()
def simulate(
    scenario: ScenarioArgument,
    flow: Annotated[str, typer.Option(help=FLOWS, autocompletion=_flow_names)] = "exact",
    model: Annotated[
        list[Path] | None,
        typer.Option(help="Model file for polynomial, neural, residual or pressure; repeat for more."),
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
        str,
        typer.Option(
            help="semi-implicit, rk4, rosenbrock or reference; the last two choose their own steps. `machine check` says which serve a machine.",
            autocompletion=lambda: ["semi-implicit", "rk4", "rosenbrock", "reference"],
        ),
    ] = "semi-implicit",
    energy: Annotated[
        bool,
        typer.Option(
            "--energy", help="Add the energy account as columns: powers of pumps, losses, joints, friction; energies."
        ),
    ] = False,
    forces: Annotated[
        bool,
        typer.Option("--forces", help="Add forces as columns: of cylinders and motors, friction, and joint pins."),
    ] = False,
    stability: Annotated[
        bool,
        typer.Option("--stability", help="Add margins against tipping as columns, and say how close the run comes."),
    ] = False,
    fault: FaultOption = None,
    units: UnitsOption = METRIC,
    machine: OwnMachineOption = None,
) -> None:
    """Simulate a scenario, say what happened, and how far the run is from that with the exact flow.

    Prints the largest pressures, events, where the machine ended, warnings, and how long it took to compute.

    Example: `polydraulic simulate task --out task.parquet --plot task.svg`

    - With the iteration that the closed form replaces: `polydraulic simulate step --flow iterative`

    - Networks of your own: `polydraulic simulate single_08 --flow polynomial --model q_in.json --plot run.svg`

    - What a real operator did, from a CSV file with the columns time [s], swing [V], boom [V], stick [V]:
    `polydraulic simulate recording.csv --raster 0.05 --out run.csv`

    - A pump that wears while it works: `polydraulic simulate task --fault "boom.pump_worn 20 % from 10 s" --plot worn.svg`

    - Ten minutes of a random operator: `polydraulic simulate random:42:600 --raster 0.1 --out run.parquet`

    `polydraulic scenarios` lists the scenarios that come with the package. What comes next: `polydraulic animate` shows the linkage
    move, `polydraulic record` writes what sensors would have measured, `polydraulic export-machine` writes C code and FMUs.
    """
    from polydraulic.display import readable
    from polydraulic.files import check_apart
    from polydraulic.flow.dispatch import build_flow
    from polydraulic.networks.model.model_file import load_models
    from polydraulic.parameters.load import load_machine
    from polydraulic.parameters.scenario import load_scenario, scenario_files, scenario_machine
    from polydraulic.plotting.run_figure import picture_ending, plot_run, save_figure
    from polydraulic.simulation.runs import simulate as run
    from polydraulic.simulation.summary import run_summary
    from polydraulic.simulation.trajectory import compare
    from polydraulic.tables import table_ending, write_table

    if model and flow not in ("polynomial", "neural", "residual", "pressure"):
        raise InputError(f"--model goes with --flow polynomial, neural, residual or pressure, not with {flow!r}")
    if arrangement and (flow != "polynomial" or model):
        raise InputError("--arrangement goes with --flow polynomial and the package's own networks")
    if out is not None:
        table_ending(out)
        check_apart(out, [*scenario_files(scenario), *(model or ())])
    if plot is not None:
        picture_ending(plot)
    plant = load_machine(machine or scenario_machine(scenario))
    what = load_scenario(scenario, functions=plant.names)
    options: dict[str, Any] = {"arrangement": arrangement} if arrangement else {}
    options |= {"models": [found for path in model for found in load_models(path)]} if model else {}
    names = list(dict.fromkeys(["exact", flow]))
    settings: Any = {
        "dt": dt,
        "raster": raster,
        "method": method,
        "energy": energy,
        "forces": forces,
        "stability": stability,
        "faults": fault or (),
    }
    runs, seconds, pieces = {}, 0.0, 2 * len(names) + 3
    with progress_bar("simulate") as progress:
        progress(f"flow model {flow}", 0, pieces)
        chosen = build_flow(flow, plant, **options)
        for number, name in enumerate(names):
            used = chosen if name == flow else name
            progress(f"compile for {name} (once after an installation)", 2 * number + 1, pieces)
            first_row = min(dt if raster is None else raster, what.duration)
            run(plant, used, what, t_end=first_row, **settings)
            progress(name, 2 * number + 2, pieces)
            begun = time.perf_counter()
            runs[name] = run(plant, used, what, **settings)
            seconds = time.perf_counter() - begun
        if out is not None:
            progress(f"write {out}", pieces - 2, pieces)
            write_table(runs[flow], out)
        if plot is not None:
            progress(f"draw {plot}", pieces - 1, pieces)
            save_figure(plot_run(runs, units=units), plot)
    info = runs[flow].info
    print(f"{what.name} on {machine or scenario_machine(scenario)}: {what.title}")
    how = (
        f"{method} with flow {flow!r} to a relative tolerance of {info['rtol']:g}, every {dt:g} s"
        if "rtol" in info
        else f"{info['steps']} steps of {dt:g} s with flow {flow!r}"
    )
    simulated = float(runs[flow]["time"][-1])
    print(
        f"{how}; {simulated:g} s computed in {seconds:.3g} s, {readable(simulated / seconds, 2)} times as fast as real time"
    )
    print("\n".join(run_summary(runs[flow], units)))
    if flow != "exact":
        print_differences(compare(runs["exact"], runs[flow]), units)


@app.command()
def animate(
    scenario: ScenarioArgument,
    out: Annotated[Path, typer.Option(help="Animation to write: .html plays in any browser, .gif anywhere.")],
    flow: Annotated[
        list[str] | None,
        typer.Option(help=f"{FLOWS} Repeat to overlay runs; exact if not given.", autocompletion=_flow_names),
    ] = None,
    dt: Annotated[float, typer.Option(help="Time step in s.")] = 0.005,
    rate: Annotated[
        float | None,
        typer.Option(help="Frames per second; 20 for .html, which interpolates between them, 12.5 for .gif."),
    ] = None,
    units: UnitsOption = METRIC,
    machine: OwnMachineOption = None,
) -> None:
    """Show the linkage move: side view, view from above, angles, flows and pressures.

    Example: `polydraulic animate task --flow exact --flow iterative --out task.html`

    - As a GIF: `polydraulic animate step --out step.gif`

    - A random operator: `polydraulic animate random:42:30 --out operator.html`

    The first flow is drawn filled, the others as outlines; distances of the tip are from the first. What comes next: open the page in
    a browser; `polydraulic simulate` with the same scenario prints the numbers.
    """
    from polydraulic.parameters.load import load_machine
    from polydraulic.parameters.scenario import load_scenario, scenario_machine
    from polydraulic.plotting.animation import animation_ending, write_animation
    from polydraulic.simulation.runs import simulate as run

    animation_ending(out)
    plant = load_machine(machine or scenario_machine(scenario))
    what = load_scenario(scenario, functions=plant.names)
    flows = list(dict.fromkeys(flow or ["exact"]))
    runs = {}
    with progress_bar("animate") as progress:
        for number, name in enumerate(flows):
            progress(f"simulate with flow {name}, compiled once after an installation", number, len(flows) + 1)
            runs[name] = run(plant, name, what, dt=dt)
        progress(f"draw {out}", len(flows), len(flows) + 1)
        write_animation(runs, plant, out, rate=rate, units=units, progress=progress)
    print(f"{out}: {what.name}, {', '.join(flows)}")


@app.command()
def scenarios() -> None:
    """List the scenarios that come with the package.

    Example: `polydraulic scenarios`

    What comes next: `polydraulic simulate NAME --plot run.svg`, or `polydraulic animate NAME --out run.html`. A scenario of your own is a
    TOML file like those in the package, or a recording: a CSV file with the columns time, swing, boom, stick. `machine = "..."` in a
    scenario file says which machine it is for; `simulate` and `animate` take that one.
    """
    from polydraulic.parameters.load import load_machine
    from polydraulic.parameters.scenario import load_scenario, scenario_machine, scenario_names

    rows = []
    for name in scenario_names():
        what, machine = load_scenario(name), scenario_machine(name)
        moved = ", ".join(f for f in load_machine(machine).names if f not in what.locked)
        rows.append((name, what.duration, machine, moved, what.title))
    rows.append(("random:SEED", 60.0, "any", "all", "Random operator; random:SEED:SECONDS for another duration"))
    first, second, third = (max(len(str(row[column])) for row in rows) for column in (0, 2, 3))
    for name, duration, machine, moved, title in rows:
        print(f"{name:{first}s} {duration:5g} s  {machine:{second}s}  {moved:{third}s}  {title}")


@app.command()
def sample(
    rows: Annotated[int, typer.Option(help="Number of rows.")],
    out: Annotated[Path, typer.Option(help="Table to write, .parquet or .csv (SI).")],
    circuit: Annotated[
        str | None,
        typer.Option(
            help="A circuit of the machine, the first if not given: of cat215b boom, and series of two valves that share a pump."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the random points.", min=0)] = 0,
    relief: Annotated[bool, typer.Option(help="With the pump's relief valve, or the ideal circuit without.")] = True,
    machine: MachineOption = "cat215b",
) -> None:
    """Evaluate a circuit at random points: a training database, from which `fit` makes networks for `simulate --model`.

    Example: `polydraulic sample --circuit boom --rows 10000 --out boom.parquet`

    - Two valves in series: `polydraulic sample --circuit series --rows 50000 --out series.parquet`

    - Of a machine of any layout: `polydraulic sample --circuit lift --rows 50000 --out lift.parquet --machine loader_crane`

    What comes next: `polydraulic fit boom.parquet --inputs boom.travel,boom.p_in --outputs boom.q_in --out q_in.json`.
    """
    import numpy as np

    from polydraulic.flow.layout.database import sample_circuit
    from polydraulic.parameters.load import load_machine
    from polydraulic.tables import write_table

    plant = load_machine(machine)
    with progress_bar("sample") as progress:
        progress(f"{rows} points of the circuit", 0, 2)
        table = sample_circuit(plant, circuit, rows, rng=np.random.default_rng(seed), relief=relief)
        progress(f"write {out}", 1, 2)
        write_table(table, out)
    print(f"{out}: {rows} rows of {', '.join(table.names)}")


@app.command()
def train(
    out: Annotated[Path, typer.Option(help="Model file to write, .json.")],
    machine: MachineOption = "cat215b",
    circuit: Annotated[
        list[str] | None, typer.Option(help="A circuit to learn; repeat for more; all if not given.")
    ] = None,
    tolerance: Annotated[
        float | None, typer.Option(help="Largest error to look for, as a share of the pump's flow; 0.001 if not given.")
    ] = None,
    regions: Annotated[
        int | None, typer.Option(help="Most regions of a network; 64 if not given. Fewer are learnt sooner.")
    ] = None,
    kind: Annotated[
        str, typer.Option(help="polynomial, or neural: perceptrons.", autocompletion=lambda: ["polynomial", "neural"])
    ] = "polynomial",
) -> None:
    """Train the networks of a whole machine from its exact flow model.

    All networks go into one file: of each circuit what enters its valves and what leaves the actuators. It prints the largest error of each, as a
    share of the pump's flow or of the widest orifice, and warns above 5 %.

    Example: `polydraulic train --out loader.json --machine wheel_loader`

    - In seconds, for a first look: `polydraulic train --out loader.json --machine wheel_loader --regions 9 --tolerance 0.02`

    - Perceptrons for `--flow neural`: `polydraulic train --out perceptrons.json --machine wheel_loader --kind neural`

    What comes next: `polydraulic simulate wheel_loader_cycle --flow polynomial --model loader.json`.
    """
    from polydraulic.flow.training.layout_models import TrainingEffort, train_layout
    from polydraulic.flow.training.layout_perceptrons import train_layout_perceptrons
    from polydraulic.flow.training.map_shares import large_errors, map_shares
    from polydraulic.networks.model.model_file import save_models
    from polydraulic.parameters.load import load_machine

    if kind not in ("polynomial", "neural"):
        raise InputError(f"--kind {kind}: choose polynomial or neural")
    if kind == "neural" and tolerance is not None:
        raise InputError("--tolerance goes with --kind polynomial: perceptrons learn from points that are given")
    plant = load_machine(machine)
    given = {"tolerance": tolerance, "regions": regions}
    settings: Any = {name: value for name, value in given.items() if value is not None}
    if out.suffix.lower() != ".json":
        raise InputError(f"--out {out}: all networks go into one file, for example {out.name}.json")
    effort = TrainingEffort(**settings)
    with progress_bar("train") as progress:
        if kind == "neural":
            models = train_layout_perceptrons(plant, circuits=circuit or None, progress=progress, **settings)
        else:
            models = train_layout(plant, circuits=circuit or None, effort=effort, progress=progress)
        save_models(models, out)
    shares = map_shares(models, plant)
    for name, model in zip(shares, models, strict=True):
        print(f"{name:32s} {len(model.networks):3d} regions, largest error {shares[name]:.2%}")
    print(out)
    for line in large_errors(shares, effort.tolerance, effort.regions if kind == "polynomial" else None):
        print(f"warning: {line}")
