"""Commands about faults: what can break on a machine."""

import typer

from polydraulic.cli.application import MachineOption, app


@app.command()
def faults(
    of: str = typer.Argument("", help="Show those of one owner alone, boom or boom.angle; all if not given."),
    machine: MachineOption = "cat215b",
) -> None:
    """List the faults that a machine can have: name, usual sizes, the first of which is taken where none is given, and what changes.

    A fault is a change of the machine's numbers, or of what a sensor reads, from a time on; it may grow, and it may end. Its size may be any
    other than the usual ones.

    Example: `polydraulic faults --machine wheel_loader`

    - Those of one function: `polydraulic faults boom`

    What comes next: `polydraulic simulate task --fault "boom.pump_worn 10 % from 5 s"` runs a machine with one,
    `polydraulic record random:1:600 --fault "boom.p_a.bias from 60 s" --sensors sensors.toml --out log.mf4` writes what sensors read of it. In
    a scenario file a fault is a table `[[faults]]` with name, and size, begin, end and growth where they are wanted.
    """
    from polydraulic.errors import InputError
    from polydraulic.parameters.fault_catalogue import fault_catalogue

    found = fault_catalogue(machine)
    owners = sorted({kind.name.rpartition(".")[0] for kind in found} | {kind.name.partition(".")[0] for kind in found})
    if of and of not in owners:
        raise InputError(f"no faults of {of!r}; there are some of {', '.join(owners)}")
    shown = [kind for kind in found if not of or kind.name.startswith(f"{of}.")]
    rows = [
        (kind.name, ", ".join(kind.shown(size) for size in kind.sizes) or "-", kind.words.format("SIZE"))
        for kind in shown
    ]
    name, sizes = (max(len(row[k]) for row in rows) for k in (0, 1))
    for row in rows:
        print(f"{row[0]:{name}s}  {row[1]:{sizes}s}  {row[2]}")
