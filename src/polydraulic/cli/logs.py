"""Commands of measured logs: import, record, fit-machine."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.app import MachineOption, app
from polydraulic.errors import InputError
from polydraulic.terminal import counted, steps


@app.command("import")
def import_(
    log: Annotated[Path, typer.Argument(help="Log: .csv, .csv.gz, .parquet, .mf4 (MDF4) or .mat (v5, v7.3).")],
    channels: Annotated[Path | None, typer.Option(help="Channel map, TOML.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Table to write, .parquet or .csv (SI); with --suggest the channel map.")
    ] = None,
    suggest: Annotated[bool, typer.Option("--suggest", help="Write a first channel map for the log.")] = False,
    report: Annotated[
        Path | None, typer.Option(help="Quality report, .html; beside the table if not given. Its data as .json.")
    ] = None,
) -> None:
    """Make a table from a measured log, and say what is wrong with the log.

    The table holds rows on one raster where all inputs and outputs are known; the column `segment` counts pieces without a gap.

    Example: `polydraulic import log.mf4 --channels map.toml --out table.parquet`

    - A first channel map, to be gone through: `polydraulic import --suggest log.mf4 --out map.toml`
    """
    from polydraulic.files import write_text
    from polydraulic.measure import import_log, load_channels, suggest_channels, write_quality

    if suggest:
        if channels is not None or report is not None:
            raise InputError("--suggest writes a channel map; --channels and --report go with an import")
        with counted("read") as progress:
            text = suggest_channels(log, progress=progress)
        if out is None:
            print(text, end="")
        else:
            write_text(out, text)
            print(f"{out}: a first channel map; go through it")
        return
    if channels is None or out is None:
        raise InputError("an import needs --channels MAP.toml and --out TABLE; --suggest writes a first map")
    page = report or out.with_suffix(".quality.html")
    if page.suffix != ".html":
        raise InputError(f"{page}: a quality report ends in .html")
    given = load_channels(channels)
    with counted("import") as progress:
        imported = import_log(log, given, out, progress=progress)
    told = write_quality(imported, page)
    for finding in imported.findings:
        print(f"{finding.level}: {finding}")
    for found in told.deadbands:
        print(found.statement(imported.shown.get(found.input)))
    if imported.n_row == 0:
        raise InputError(f"{log}: no row of a table came of it; {page} says why")
    print(
        f"{out}: {imported.n_row} rows in {imported.n_segment} segment(s); {page}: {len(imported.findings)} finding(s)"
    )


@app.command()
def record(
    scenario: Annotated[
        list[str], typer.Argument(help="Scenarios as for simulate, recorded one after the other; random:SEED:SECONDS.")
    ],
    sensors: Annotated[Path, typer.Option(help="Sensors, TOML: what they read, how well and how often.")],
    out: Annotated[Path, typer.Option(help="Log to write, .csv, .mf4 or .parquet.")],
    dt: Annotated[float, typer.Option(help="Time step of the simulation in s.")] = 0.005,
    machine: MachineOption = "cat215b",
) -> None:
    """Simulate, and write what sensors would have recorded: noise, digits, delay, dropouts, drift, rasters.

    Example: `polydraulic record random:1:600 random:2:600 --sensors sensors.toml --out log.mf4`
    """
    from polydraulic.measure import load_sensors
    from polydraulic.measure import record as write_log
    from polydraulic.measure.record import log_ending
    from polydraulic.parameters import load_machine, load_scenario

    log_ending(out)
    bench, plant = load_sensors(sensors), load_machine(machine)
    what = [load_scenario(name) for name in scenario]
    with steps("record", len(what)) as progress:
        n = write_log(plant, what, bench, out, dt=dt, progress=progress)
    print(f"{out}: {n} samples of {len(bench.sensors)} sensors")


@app.command()
def fit_machine(
    table: Annotated[
        Path, typer.Argument(help="Imported table with LINK.spool, .p_a, .p_b, .q_in, .q_out of all links.")
    ],
    out: Annotated[Path, typer.Option(help="Model file to write, .json.")],
    machine: Annotated[str, typer.Option(help="Parameter set by name, or a TOML file.")] = "cat215b",
) -> None:
    """Learn the pump and valves of a whole machine from a log of its work; orifice areas are not needed.

    Of the parameter set only pump flows, relief setting, return pressure and the borders of spool travel are used.

    Example: `polydraulic fit-machine table.parquet --out machine.json`

    - Drive the machine with it: `polydraulic simulate task --flow polynomial --model machine.json --plot task.svg`
    """
    from polydraulic.networks import save_models
    from polydraulic.parameters import LINKS, load_machine
    from polydraulic.studies.machine_from_log import MEASURED, by_port, learn
    from polydraulic.tables import read_table

    plant = load_machine(machine)
    log = read_table(table, [f"{link}.{what}" for link in LINKS for what in MEASURED])
    with steps("fit-machine", 6) as progress:
        models = learn(plant, by_port(plant, log), progress)
    save_models(models, out)
    for model in models:
        print(f"{model.output}: {len(model.networks)} network(s), {model.n_coefficients} coefficients")
