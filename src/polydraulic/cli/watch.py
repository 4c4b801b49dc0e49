"""The command that watches a machine through its log."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import app, say_self_test, say_written
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar


@app.command()
def watch(
    log: Annotated[
        list[str],
        typer.Argument(
            help="Imported table in SI, with what sensors there are; several tables, or a pattern in quotes."
        ),
    ],
    machine: Annotated[
        str, typer.Option(help="The healthy machine, by name or a TOML file: best what `identify` made of its own log.")
    ],
    healthy: Annotated[
        list[str] | None,
        typer.Option(
            help="Table of healthy work, from which noise is learnt; the first third of the log, 10 min at most, if not given."
        ),
    ] = None,
    sensors: Annotated[
        list[str] | None,
        typer.Option(help="Columns to watch by, names or patterns such as `*.p_?`; repeat for more; all if not given."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Page to write, .html: alarms, evidence over time, what can be told.")
    ] = None,
    false_alarms: Annotated[
        float | None,
        typer.Option("--false-alarms", help="Per hour, that all tests together are set to; 0.1 if not given."),
    ] = None,
    networks: Annotated[
        Path | None,
        typer.Option(
            help="Abductive networks, .json, that name the kind of a fault as well; learnt from simulated faults and written if the file is not there."
        ),
    ] = None,
    export: Annotated[
        list[Path] | None,
        typer.Option(
            help="Folder to write the watch to as C99, or an .fmu file: rows in, alarms out, networks with it if there are some; repeat for both."
        ),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 1 if there is an alarm that is no unusual work.")
    ] = False,
) -> None:
    """Watch a machine through its log: what is wrong, since when, how sure that is, and what else it could be.

    Flows, pressures, spools and torques that sensors read are compared with those of the healthy machine, second by second; a fault of the
    catalogue (`polydraulic faults`) is what would make of the healthy machine that which is read. A fault that could not have shown (a low relief
    setting shows at the relief valve alone) is said not to be told, and a payload or cold oil are named as the unusual work that they are.

    Columns are NAME.voltage, .spool, .p_a, .p_b, .q_in, .q_out, .angle (.position of a joint that slides). With fewer of them fewer faults are told apart.

    Example: `polydraulic watch later.parquet --machine identified.toml --healthy day1.parquet --out watch.html`

    - With pressures, angles and levers alone: `polydraulic watch later.parquet --machine identified.toml --sensors '*.p_?' --sensors '*.angle' --sensors '*.voltage'`

    - For a controller, without Python: `polydraulic watch later.parquet --machine identified.toml --healthy day1.parquet --export watch_c --export watch.fmu`

    - To try it: `polydraulic record random:5:600 --fault "boom.leak_across from 300 s" --sensors sensors.toml --out log.mf4`, then `polydraulic import`

    What comes next: look at the page in a browser; a table that is healthy beyond doubt makes a better `--healthy`.
    """
    from polydraulic.export.model_bundle import c_name
    from polydraulic.export.watch.fmu import export_watch_fmu
    from polydraulic.export.watch.source import export_watch
    from polydraulic.identification.watching.fault_networks import networks_for
    from polydraulic.identification.watching.watch_log import watch_log
    from polydraulic.identification.watching.watch_page import watch_page_ending, write_watch_page
    from polydraulic.watch.learning import FALSE_ALARMS
    from polydraulic.watch.watch import FaultWatch

    if out is not None:
        watch_page_ending(out)
    for path in export or ():
        if path.suffix not in ("", ".fmu"):
            raise InputError(f"--export {path}: must be a folder, for C99, or end in .fmu")
    rate = FALSE_ALARMS if false_alarms is None else false_alarms
    with progress_bar("watch") as progress:
        found = watch_log(
            log, machine, healthy=healthy, sensors=sensors, rate=rate, networks=networks, progress=progress
        )
        if out is not None:
            write_watch_page(found, out)
    print(found)
    say_written(out)
    asked = networks_for(networks, found.of, found.expected) if networks is not None and export else None
    for path in export or ():
        watch, name = FaultWatch(found.of, found.expected, rate, asked), c_name(path.stem)
        written = export_watch_fmu(watch, path, name=name) if path.suffix else export_watch(watch, path, name=name)
        print(written)
        if not path.suffix:
            say_self_test(written.files[1])
    if strict and found.faulty:
        raise typer.Exit(1)
