"""The application that commands join, and what several of them take."""

from collections.abc import Iterable
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from polydraulic.errors import InputError
from polydraulic.progress import Progress
from polydraulic.terminal import loading

if TYPE_CHECKING:
    from polydraulic.identification.dynamic_fit import DynamicFit
    from polydraulic.identification.machine.machine_fit import MachineFit
    from polydraulic.identification.table_fit import TableFit

# commands as people come to them, under what they are after
PANELS = {
    "Simulate a machine": ("simulate", "animate", "scenarios", "cockpit", "cockpit-export", "faults", "loadchart"),
    "Describe a machine": ("machine", "export-machine"),
    "Read a measured log": ("import", "record", "identify", "fit-machine", "fit-joints", "replay", "watch", "payload"),
    "Learn from a table, and use what was learnt": ("fit", "check", "run", "export", "verify", "sample", "train"),
    "The thesis": ("report",),
}


class _InPanels(TyperGroup):
    """Lists commands in the order of `PANELS`."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands, each put under its panel."""
        for panel, names in PANELS.items():
            for name in names:
                self.commands[name].rich_help_panel = panel  # type: ignore[attr-defined]
        return [name for names in PANELS.values() for name in names]


app = typer.Typer(
    cls=_InPanels,
    help="Polynomial abductive networks and real-time simulation of mobile hydraulic machines.\n\n"
    "First steps: `polydraulic simulate task --plot task.svg` moves an excavator that comes with the package, "
    "`polydraulic fit --help` learns from a table, `polydraulic import --help` reads a measured log. "
    "Each command's `--help` shows an example and what comes next.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


def _version(asked: bool) -> None:
    if asked:
        from polydraulic import __version__

        print(f"polydraulic {__version__}")
        raise typer.Exit


@app.callback()
def options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Options of the program itself; its help is that of `app`."""
    context.with_resource(loading())


def _checked(units: str) -> str:
    from polydraulic.display import checked_units

    return checked_units(units)


def say_written(*paths: Path | None) -> None:
    """One line for each file that was asked for."""
    for path in paths:
        if path is not None:
            print(f"{path}: written")


def say_self_test(source: Path, *others: Path) -> None:
    """How exported C is tried, which may need other sources."""
    sources = " ".join(quote(str(path)) for path in (*others, source))
    print(
        f"it tests itself: gcc -std=c99 -D{source.stem.upper()}_SELF_TEST {sources} -lm, and run what comes of it: exit code 0 where it answers "
        "as the package does"
    )


def check_endings(out: Path, card: Path | None) -> None:
    """Refuse files that a fit cannot write before it takes its time: the model, and the card if one is asked for."""
    from polydraulic.identification.model_card import card_ending
    from polydraulic.networks.model.model_file import model_ending

    model_ending(out)
    if card is not None:
        card_ending(card)


def keep_fit(
    found: "TableFit | DynamicFit | MachineFit",
    out: Path,
    card: Path | None,
    *,
    boxes: int,
    units: str,
    progress: Progress,
) -> None:
    """Write the models of a fit, and its card if one is asked for."""
    from polydraulic.identification.model_card import write_card
    from polydraulic.networks.model.model_file import save_models

    save_models(found.models, out)
    if card is not None:
        write_card(found, card, max_boxes=boxes, units=units, progress=progress)


def joined(texts: Iterable[str]) -> str:
    """The list of an option that was given once or several times: what is separated by commas goes on from one to the next."""
    return ",".join(texts)


def values_by_name(texts: Iterable[str], option: str) -> dict[str, str]:
    """What an option NAME=VALUE gives each name, which may be repeated for other names."""
    found: dict[str, str] = {}
    for text in texts:
        name, _, value = (part.strip() for part in text.partition("="))
        if name in found:
            raise InputError(f"{option} {name}: is given twice, {found[name]!r} and {value!r}; give it once")
        found[name] = value
    return found


METRIC = "metric"  # what people read if they ask for nothing else
MachineOption = Annotated[str, typer.Option(help="A machine by name, or a TOML file.")]
FaultOption = Annotated[
    list[str] | None,
    typer.Option(
        "--fault",
        help="What breaks, and when: NAME [SIZE] [from TIME] [to TIME] [over TIME], as 'boom.pump_worn 10 % from 60 s'; repeat for more. `polydraulic faults` lists names.",
    ),
]
UnitsOption = Annotated[
    str,
    typer.Option(
        "--units",
        help="Of what is printed and drawn: metric (bar, l/min, mm, deg), field (psi, in3/s, in, deg) or si. Files stay in SI.",
        callback=_checked,
        autocompletion=lambda: ["metric", "field", "si"],
    ),
]
