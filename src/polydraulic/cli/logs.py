"""Commands of measured logs: import, record, fit-machine, replay."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from polydraulic.cli.application import (
    METRIC,
    FaultOption,
    MachineOption,
    UnitsOption,
    app,
    check_endings,
    keep_fit,
    say_written,
)
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar

if TYPE_CHECKING:
    from polydraulic.measure.importing import Imported


@app.command("import")
def import_(
    log: Annotated[
        list[str],
        typer.Argument(
            help="Log: .csv, .csv.gz, .parquet, .mf4, .mdf, .dat (MDF), .mat (v5, v7.3), .blf or .asc (CAN), the folder of a ROS 2 bag, .mcap, .db3 or .bag; several files of one campaign, or a pattern in quotes."
        ),
    ],
    channels: Annotated[Path | None, typer.Option(help="Channel map, TOML.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Table to write, .parquet or .csv (SI); with --suggest the channel map.")
    ] = None,
    suggest: Annotated[bool, typer.Option("--suggest", help="Write a first channel map for the log.")] = False,
    report: Annotated[
        Path | None, typer.Option(help="Quality report, .html; beside the table if not given. Its data as .json.")
    ] = None,
    dbc: Annotated[list[Path] | None, typer.Option(help="CAN database of a bus log, .dbc; repeat for more.")] = None,
    strict: Annotated[
        bool,
        typer.Option("--strict", help="Exit with 1 if the log has errors, such as values beyond a range of the map."),
    ] = False,
    partial: Annotated[
        bool,
        typer.Option(
            "--partial", help="Keep rows in which some channels are silent, and declare their values as missing."
        ),
    ] = False,
    units: UnitsOption = METRIC,
) -> None:
    """Make a table from a measured log, and say what is wrong with the log.

    The table holds rows on one raster where all inputs and outputs are known, with `--partial` where any is; the column `segment` counts
    pieces without a gap.

    Example: `polydraulic import log.mf4 --channels map.toml --out table.parquet`

    - A first channel map, to be gone through: `polydraulic import --suggest log.mf4 --out map.toml`

    - A campaign: `polydraulic import "day1_*.csv" --channels map.toml --out table.parquet --strict`

    What comes next: look at the quality report in a browser and correct the map; then `polydraulic identify` finds curves and numbers of a machine
    file, `polydraulic fit-machine` learns pump and valves of a whole machine, `polydraulic fit-joints` how joints follow levers, `polydraulic fit`
    anything else, and `polydraulic watch` says what is wrong with the machine.
    """
    from polydraulic.files import check_apart, check_new, write_text
    from polydraulic.measure.channels import load_channels
    from polydraulic.measure.formats.campaign import expand
    from polydraulic.measure.importing import import_log, missing_in_words
    from polydraulic.measure.quality import write_quality
    from polydraulic.measure.suggest import suggest_channels

    if suggest:
        if channels is not None or report is not None or partial:
            raise InputError("--suggest writes a channel map; --channels, --report and --partial go with an import")
        if out is not None:
            check_apart(out, expand(log))
            check_new(out)
        with progress_bar("read") as progress:
            text = suggest_channels(log, dbc=dbc or (), progress=progress)
        if out is None:
            print(text, end="")
        else:
            write_text(out, text)
            print(
                f"{out}: a first channel map; go through it: say which channels are outputs, and whether units and ranges are right"
            )
        return
    if channels is None or out is None:
        raise InputError("an import needs --channels MAP.toml and --out TABLE; --suggest writes a first map")
    page = report or out.with_suffix(".quality.html")
    if page.suffix != ".html":
        raise InputError(f"{page}: a quality report ends in .html")
    given = load_channels(channels)
    with progress_bar("import") as progress:
        imported = import_log(log, given, out, dbc=dbc or (), partial=partial, progress=progress)
        progress("deadbands, coverage, quality report", 0, 1)
        told = write_quality(imported, page, units=units)
    for line in _told(imported, page):
        print(line)
    for found in told.deadbands:
        print(found.statement(imported.shown(units).get(found.input)))
    if imported.n_row == 0:
        raise InputError(f"{imported.source}: gives no row of a table; {page} says why")
    print(
        f"{out}: {imported.n_row} rows in {imported.n_segment} segment(s); {page}: {len(imported.findings)} finding(s)"
    )
    if imported.missing is not None:
        print(f"rows in which a channel has no value, kept as missing: {missing_in_words(imported.missing)}")
    errors = sum(finding.level == "error" for finding in imported.findings)
    if strict and errors:
        print(f"--strict: {errors} error(s) above")
        raise typer.Exit(1)


def _told(imported: "Imported", page: Path) -> list[str]:
    """A line for each finding, errors first; dropouts, which most channels of a log have, in one for all."""
    dropouts = imported.findings.of("dropout")
    single = [f for f in imported.findings if f.kind != "dropout" or len(dropouts) == 1]
    lines = [f"{finding.level}: {finding}" for finding in single]
    if len(dropouts) > 1:
        lost = max(check.lost for check in imported.checks)
        whole = "the table has no rows there; --partial keeps what other channels read"
        where = whole if imported.missing is None else "their values are missing there"
        lines.append(
            f"{dropouts[0].level}: dropouts in {len(dropouts)} channels, up to {lost:.4g} s in one; {where}; see {page}"
        )
    return lines


@app.command()
def record(
    scenario: Annotated[
        list[str] | None,
        typer.Argument(help="Scenarios as for simulate, recorded one after the other; random:SEED:SECONDS:VOLTS."),
    ] = None,
    sensors: Annotated[
        Path | None, typer.Option(help="Sensors, TOML: what they read, how accurately and how often.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Log to write, .csv, .mf4 or .parquet; with --example the sensors, .toml.")
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Write sensors to begin with: all that fit-machine and replay read.")
    ] = False,
    seed: Annotated[
        int | None,
        typer.Option(help="Of the sensors' errors, instead of the file's: another one for another day.", min=0),
    ] = None,
    full_stroke: Annotated[
        bool,
        typer.Option("--full-stroke", help="Random operators give as much voltage as drives every spool to its end."),
    ] = False,
    dt: Annotated[float, typer.Option(help="Time step of the simulation in s.")] = 0.005,
    fault: FaultOption = None,
    machine: MachineOption = "cat215b",
) -> None:
    """Simulate, and write what sensors would have recorded: noise, resolution, delay, dropouts, drift, rasters.

    Example: `polydraulic record random:1:600 random:2:600 --sensors sensors.toml --out log.mf4`

    - Sensors to begin with: `polydraulic record --example --out sensors.toml`

    - A log to identify valves from: `polydraulic record random:1:600 --full-stroke --sensors sensors.toml --out log.mf4`

    - Another day: the same sensors err in the same way with the same seed, so give it one of its own with `--seed 2`

    - A machine that wears: `polydraulic record random:1:600 --fault "boom.pump_worn 10 % from 60 s over 300 s" --sensors sensors.toml --out log.mf4`

    What comes next: `polydraulic import --suggest log.mf4 --out map.toml`, as with a log of a real machine.
    """
    from dataclasses import replace

    from polydraulic.files import check_apart, check_new, write_text
    from polydraulic.measure.bench.recording import log_ending
    from polydraulic.measure.bench.recording import record as write_log
    from polydraulic.measure.bench.sensors import example_sensors, load_sensors
    from polydraulic.parameters.fault_catalogue import timed_faults
    from polydraulic.parameters.layout.adapt import at_full_stroke
    from polydraulic.parameters.load import load_machine
    from polydraulic.parameters.scenario import load_scenario, scenario_files

    if example:
        if scenario or sensors is not None:
            raise InputError("--example writes sensors; scenarios and --sensors go with a recording")
        if out is None:
            print(example_sensors(machine=machine), end="")
        else:
            if out.suffix.lower() != ".toml":
                raise InputError(f"{out}: sensors are a .toml file")
            check_new(out)
            write_text(out, example_sensors(machine=machine))
            print(f"{out}: sensors to begin with; change them as you like")
        return
    if not scenario or sensors is None or out is None:
        raise InputError(
            "a recording needs a scenario, --sensors SENSORS.toml and --out LOG; --example writes sensors to begin with"
        )
    log_ending(out)
    check_apart(out, [sensors, *(path for name in scenario for path in scenario_files(name))])
    bench, plant = load_sensors(sensors), load_machine(machine)
    bench = bench if seed is None else replace(bench, seed=seed)
    given = [at_full_stroke(name, plant) for name in scenario] if full_stroke else scenario
    if full_stroke and given == scenario:
        own = f"{', '.join(scenario)} {'have their' if len(scenario) > 1 else 'has its'} own"
        raise InputError(f"--full-stroke gives random operators their voltage, random:SEED:SECONDS; {own}")
    what = [load_scenario(name, functions=plant.names) for name in given]
    with progress_bar("record") as progress:
        progress("compile (once after an installation)", 0, len(what))
        n = write_log(plant, what, bench, out, dt=dt, faults=fault or (), progress=progress)
    print(f"{out}: {n} samples of {len(bench.sensors)} sensors")
    for one in timed_faults(plant, fault or ()):
        print(f"fault: {one}")


@app.command()
def fit_machine(
    table: Annotated[
        list[str],
        typer.Argument(
            help="Imported table with NAME.spool, .p_a, .p_b, .q_in, .q_out of all functions; several tables, or a pattern in quotes."
        ),
    ],
    out: Annotated[Path, typer.Option(help="Model file to write, .json.")],
    machine: MachineOption = "cat215b",
    circuit: Annotated[
        list[str] | None, typer.Option(help="A circuit to learn; repeat for more; all if not given.")
    ] = None,
    card: Annotated[
        Path | None, typer.Option(help="Model card to write, .html: coverage, errors, intervals, proofs, equations.")
    ] = None,
    regions: Annotated[int, typer.Option(help="Most regions that the network of an inlet may find.", min=1)] = 16,
    rows: Annotated[int, typer.Option(help="Most rows that a network learns from.", min=1)] = 30_000,
    blocks: Annotated[int, typer.Option(help="Fewest blocks of time, of which every fifth is held out.", min=5)] = 20,
    boxes: Annotated[
        int, typer.Option(help="With --card: sub-boxes per region that its proofs may take.", min=1)
    ] = 200,
    units: UnitsOption = METRIC,
) -> None:
    """Learn the pump and valves of a whole machine from a log of its work; orifice areas are not needed.

    Of the parameter set only pump flows, relief setting, return pressure and the limits of spool travel are used. It learns any machine whose
    circuits are valves in series; with `--circuit` those of which a log has the sensors.

    Every fifth block of time is held out to state the errors; the models are then learnt from all rows. With the columns
    NAME.voltage and NAME.angle, the machine is also run against the blocks held out, as `replay` does.

    Example: `polydraulic fit-machine table.parquet --out machine.json --card machine.html`

    - Drive the machine with it: `polydraulic simulate task --flow polynomial --model machine.json --plot task.svg`

    - Another machine: `polydraulic fit-machine table.parquet --machine wheel_loader --out loader.json`

    - Does it hold on another day's log? `polydraulic check machine.json --data later.parquet`

    What comes next: `polydraulic replay later.parquet --model machine.json` runs the machine against another log.
    """
    from polydraulic.identification.machine.machine_fit import fit_machine as fit

    check_endings(out, card)
    with progress_bar("fit-machine") as progress:
        found = fit(
            table,
            machine,
            circuits=circuit or None,
            max_regions=regions,
            max_rows=rows,
            min_blocks=blocks,
            progress=progress,
        )
        keep_fit(found, out, card, boxes=boxes, units=units, progress=progress)
    print(found.text(units))
    say_written(out, card)


@app.command()
def replay(
    table: Annotated[
        list[str],
        typer.Argument(
            help="Imported table with NAME.voltage, .angle (.position where it slides), .spool, .p_a, .p_b of all functions; several tables, or a pattern in quotes."
        ),
    ],
    flow: Annotated[str, typer.Option(help="Flow model, as for simulate.")] = "polynomial",
    model: Annotated[
        list[Path] | None, typer.Option(help="Model file for polynomial, neural or residual; repeat for more.")
    ] = None,
    seconds: Annotated[float, typer.Option(help="Length of a window in s.")] = 10.0,
    dt: Annotated[float, typer.Option(help="Time step in s.")] = 0.005,
    plot: Annotated[
        Path | None, typer.Option(help="Picture of the first windows to write, .svg, .png or .pdf.")
    ] = None,
    units: UnitsOption = METRIC,
    machine: MachineOption = "cat215b",
) -> None:
    """Run a machine against a log of the real one, and say how far joints and tip drift.

    The joysticks of the log drive the machine over windows, each restarted from the measured state; nothing else of a window
    is read. It judges flow model and parameter set (masses, friction, lines) together, and needs no exact model. Columns go by the functions
    of the machine, whatever its layout.

    Example: `polydraulic replay later.parquet --model machine.json --plot replay.svg`

    - The error that the sensors alone cause, on a log of `record`: `polydraulic replay later.parquet --flow exact`

    - A machine of your own: `polydraulic replay day.parquet --machine my_crane.toml --flow exact`

    What comes next: where joints drift apart, correct masses and friction in the parameter set, or learn from a longer log.
    """
    from polydraulic.identification.log_replay import replay as run
    from polydraulic.identification.run_plot import plot_replay, shown_windows
    from polydraulic.networks.model.model_file import load_models
    from polydraulic.plotting.run_figure import picture_ending, save_figure

    if model and flow not in ("polynomial", "neural", "residual"):
        raise InputError(f"--model goes with --flow polynomial, neural or residual, not with {flow!r}")
    if plot is not None:
        picture_ending(plot)
    models = [found for path in model for found in load_models(path)] if model else None
    with progress_bar("replay") as progress:
        progress(f"flow {flow}, compiled once after an installation", 0, 1)
        found = run(table, machine, flow, models=models, seconds=seconds, dt=dt, progress=progress)
        if plot is not None:
            progress(f"draw {plot}", 0, 1)
            save_figure(plot_replay(found, units=units), plot)
    print(found.text(units))
    if plot is not None:
        print(f"{plot}: {shown_windows(found)}")
