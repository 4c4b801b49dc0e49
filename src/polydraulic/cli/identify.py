"""The command that identifies a machine from logs inside its known equations."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import METRIC, UnitsOption, app, say_written
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar


@app.command()
def identify(
    log: Annotated[
        list[str],
        typer.Argument(
            help="Imported table in SI, with what sensors there are; several tables, or a pattern in quotes."
        ),
    ],
    machine: Annotated[
        str, typer.Option(help="Machine to begin from, by name or a TOML file with links, functions and circuits.")
    ],
    out: Annotated[Path | None, typer.Option(help="Machine file to write, .toml.")] = None,
    card: Annotated[
        Path | None,
        typer.Option(help="Card to write, .html: fit, curves, what is not determined, drift against the log."),
    ] = None,
    free: Annotated[
        list[str] | None,
        typer.Option(
            help="Paths that may change, such as `functions.*.valve.*`, besides those marked free = true; repeat for more."
        ),
    ] = None,
    plan: Annotated[
        bool,
        typer.Option("--plan", help="Fit nothing; say which further sensor or motion would narrow which number most."),
    ] = False,
    residuals: Annotated[
        Path | None,
        typer.Option(
            help="Model file to write, .json: networks of what circuits leave of measured flows, where they hold on blocks of time held out; for --flow residual."
        ),
    ] = None,
    units: UnitsOption = METRIC,
) -> None:
    """Identify curves of valves, pumps, pilots, masses and friction from a log, inside the equations that are known, as a machine file.

    It takes whatever sensors there are (NAME.voltage, .spool, .p_a, .p_b, .q_in, .q_out, .angle or .position) and says what they tell. With spool
    and both port pressures of all functions of a circuit, and flows into them or their joints: curves and pump, with knots where they are
    asked for. With pressures and joints of all functions: masses and friction that are marked. With voltages and joints of all functions alone: what
    is left, through simulation. What the log does not determine keeps its value and is named. A log that determines nothing ends with exit
    code 2, and says why.

    With --residuals, networks learn what the circuits leave of measured flows. Those that hold on blocks of time
    held out are written; `simulate --flow residual --model FILE` adds them to the circuits.

    With --plan it says, before anything is fitted, what each further sensor or motion would add. It wants voltages and joints of all functions.

    Interrupted (Ctrl-C), it keeps what is finished, circuits and steps of simulation, in a folder beside --out, and the next run goes on from there.

    Example: `polydraulic identify table.parquet --machine my_machine.toml --out identified.toml --card identified.html`

    - Valves of one circuit alone: `polydraulic identify day*.parquet --machine my_machine.toml --free 'functions.boom.valve.*' --out identified.toml`

    - Masses and friction as well: `--free 'links.*' --free 'functions.*.friction.*' --free 'functions.*.valve.*'`

    - Spools that lag and are pushed back by jets, of a file that does not say so: `--free 'functions.*.valve.hysteresis' --free
    'functions.*.valve.flow_force.spring_rate' --free 'functions.*.valve.*' --free 'functions.*.pilot.*' --free 'circuits.*.pump.*'`

    - Whether dry friction holds joints: `--free 'functions.*.friction.sticks'` beside the others

    - What else to measure: `polydraulic identify table.parquet --machine my_machine.toml --plan`

    What comes next: `polydraulic machine check identified.toml`, then `polydraulic replay later.parquet --machine identified.toml --flow exact` runs it
    against another log.
    """
    from polydraulic.files import check_apart, check_writable
    from polydraulic.identification.equations.card import identification_card_ending, write_identification_card
    from polydraulic.identification.equations.identify import identify as run
    from polydraulic.identification.equations.identify import toml_ending
    from polydraulic.identification.equations.plan import plan_identification
    from polydraulic.identification.equations.residuals import learn_residuals
    from polydraulic.networks.model.model_file import model_ending, save_models

    if plan:
        if out is not None or card is not None or residuals is not None:
            raise InputError("--plan writes nothing; --out, --card and --residuals go with an identification")
        with progress_bar("plan") as progress:
            print(plan_identification(log, machine, free=free or [], progress=progress))
        return
    if out is None:
        raise InputError(
            "an identification needs --out MACHINE.toml; --plan says what further sensors and motions promise"
        )
    toml_ending(out)
    if card is not None:
        identification_card_ending(card)
    if residuals is not None:
        model_ending(residuals)
    check_apart(out, [machine])
    for path in (out, card, residuals):
        if path is not None:
            check_writable(path)
    with progress_bar("identify") as progress:
        found = run(log, machine, free=free or [], parts=out.with_name(f"{out.stem}.parts"), progress=progress)
        found.write(out)
        if card is not None:
            write_identification_card(found, card, units=units, progress=progress)
    print(found.text(units))
    say_written(out, card)
    if residuals is not None:  # what was identified is told whatever comes of these
        with progress_bar("residuals") as progress:
            left = learn_residuals(found, progress=progress)
        print(left)
        if left.models:
            save_models(left.models, residuals)
            say_written(residuals)
        else:
            stale = "; the file of that name belongs to an earlier machine" if residuals.exists() else ""
            print(f"{residuals}: not written, no network holds on blocks held out{stale}")
