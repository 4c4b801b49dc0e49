"""Commands about machine files: what there is, what is wrong with one, a first one, and the kernels of its layout."""

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from polydraulic.cli.application import METRIC, UnitsOption, app
from polydraulic.errors import InputError

if TYPE_CHECKING:
    from polydraulic.parameters.layout.schema import LayoutMachine

machines = typer.Typer(
    help="Machines of any layout as data: list them, check and draw a file, begin a new one, show its kernels.\n\n"
    "A machine file says which links there are, what moves each of them, and which pump feeds which valves: see "
    "docs/your_machine.md.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
)
app.add_typer(machines, name="machine")

MachineArgument = Annotated[str, typer.Argument(help="A machine by name, or a TOML file.")]


@machines.command("list")
def list_machines(
    circuits: Annotated[bool, typer.Option("--circuits", help="List the kinds of circuits instead.")] = False,
) -> None:
    """List the machines that come with the package, or the kinds of circuits there are.

    Example: `polydraulic machine list`

    What comes next: `polydraulic machine check NAME`, `polydraulic simulate random:1:10 --machine NAME --plot run.svg`.
    """
    from polydraulic.parameters.layout.load import CIRCUIT_KINDS
    from polydraulic.parameters.load import load_machine, machine_names, machine_title

    if circuits:
        for kind, words in CIRCUIT_KINDS.items():
            print(f"{kind:12s} {words}")
        return
    for name in machine_names():
        functions = ", ".join(load_machine(name).names)
        print(f"{name:20s} {machine_title(name)}\n{'':20s} moved by {functions}")


@machines.command()
def check(machine: MachineArgument) -> None:
    """Check a machine file: all that is wrong at once, or a summary with what to set next to its data sheet, and what is unusual.

    Strokes, times from stop to stop and the pressures that hold the machine tell whether pins, pumps and masses are right; then follow
    the methods of `simulate` that serve it.

    Exits with 2 if the file cannot be used; unusual values are warnings.

    Example: `polydraulic machine check my_machine.toml`

    What comes next: `polydraulic machine draw my_machine.toml --out my_machine.svg`, and look whether it is what you meant.
    """
    from polydraulic.machine.data_sheet import doubtful_statics, sheet_lines
    from polydraulic.parameters.layout.describe import described
    from polydraulic.parameters.layout.usual import unusual
    from polydraulic.parameters.load import load_machine
    from polydraulic.simulation.layout.served_methods import method_lines

    found = load_machine(machine)
    for line in described(found):
        print(line)
    print("from these numbers, times with all oil of its pump, pressures at the initial positions:")
    for line in (*sheet_lines(found), *method_lines(found)):
        print(line)
    for line in (*unusual(found), *doubtful_statics(found)):
        print(f"warning: {line}")
    if found.chassis is not None:
        print(_stands(found))
    print(f"{machine}: good")


def _stands(machine: "LayoutMachine") -> str:
    """How far a machine is from tipping at its initial positions."""
    import numpy as np

    from polydraulic.display import amount
    from polydraulic.machine.stability.whole_body import standing_margins
    from polydraulic.parameters.layout.chassis import edge_names

    assert machine.chassis is not None
    at, still = np.array([[f.initial.angle for f in machine.functions]]), np.zeros((1, len(machine.functions)))
    distances = standing_margins(machine, at, still, still, np.zeros((1, 3)))[0, :, 0]
    least = int(distances.argmin())
    shown = f"{amount(float(distances[least]), 'm')} from tipping {edge_names(machine.chassis)[least]} at its initial positions"
    return f"stands, {shown}" if distances[least] > 0.0 else f"warning: tips by itself: {shown}"


@machines.command()
def draw(
    machine: MachineArgument,
    out: Annotated[Path, typer.Option(help="Picture to write, .svg, .png or .pdf.")],
    units: UnitsOption = METRIC,
) -> None:
    """Draw a machine with the names of its links, pins and cylinders, the travel of its joints, and where its tip can be.

    A look at it shows whether the file says what was meant.

    Example: `polydraulic machine draw my_machine.toml --out my_machine.svg`

    What comes next: `polydraulic animate random:1:10 --machine my_machine.toml --out run.html`.
    """
    from polydraulic.plotting.machine_figure import draw_machine
    from polydraulic.plotting.run_figure import picture_ending, save_figure

    picture_ending(out)
    save_figure(draw_machine(machine, units=units), out)
    print(out)


@machines.command()
def show(
    machine: MachineArgument,
    methods: Annotated[
        bool, typer.Option("--methods", help="The equations in continuous time, and the methods that integrate them.")
    ] = False,
) -> None:
    """Print the kernels of a machine's layout: the code of a step, written out with the machine's own names.

    `--methods` is for machines that `rk4` at least serves; `polydraulic machine check` says which methods do.

    Example: `polydraulic machine show excavator_22t | less`
    """
    from polydraulic.parameters.load import load_machine
    from polydraulic.simulation.layout.methods.text import methods_text
    from polydraulic.simulation.layout.served_methods import check_method
    from polydraulic.simulation.layout.text import layout_text

    found = load_machine(machine)
    if methods:
        check_method(found, "rk4")  # what it refuses, all methods in continuous time refuse
    print((methods_text if methods else layout_text)(found))


@machines.command()
def new(
    out: Annotated[Path | None, typer.Argument(help="File to write, .toml; printed if left out.")] = None,
    like: Annotated[str, typer.Option(help="Machine to start from, by name or file.")] = "excavator_22t",
) -> None:
    """Write a machine file to start from: another machine's, with a comment on how to get each kind of number.

    Example: `polydraulic machine new my_crane.toml --like loader_crane`

    What comes next: put in your numbers, then `polydraulic machine check my_crane.toml`.
    """
    from polydraulic.files import check_new, write_text
    from polydraulic.parameters.keys import is_layout
    from polydraulic.parameters.layout.skeleton import skeleton
    from polydraulic.parameters.load import load_machine, machine_text

    if out is not None and out.suffix != ".toml":
        raise InputError(f"{out}: a machine file ends in .toml")
    if out is not None:
        check_new(out)
    text = machine_text(like)
    load_machine(like)
    if not is_layout(tomllib.loads(text)):
        raise InputError(
            f"{like}: has the older form, without [links], [functions] and [circuits], and is no pattern for a new machine"
        )
    if out is None:
        print(skeleton(text, like), end="")
        return
    write_text(out, skeleton(text, like))
    print(f"{out}: a machine like {like}; put in your numbers, then: polydraulic machine check {out}")
