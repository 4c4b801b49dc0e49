"""What commands show while they work, and a table of what they found."""

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from threading import Timer
from typing import TYPE_CHECKING

from polydraulic.progress import Progress, quiet

if TYPE_CHECKING:
    from polydraulic.simulation.trajectory import Difference

PATIENCE = 2.0  # s since the command began, before progress is shown
_BEGAN = time.monotonic()
_loading = ExitStack()


@contextmanager
def loading() -> Iterator[None]:
    """What is shown while a command loads what it needs, until it says itself by a `progress_bar` what it does."""
    with _loading:
        _loading.enter_context(_bar("loading", transient=True))
        yield


@contextmanager
def progress_bar(title: str) -> Iterator[Progress]:
    """A progress bar that appears once the command has taken longer than `PATIENCE`, where a terminal shows it.

    What it gives is the `progress` of whatever takes long.
    """
    _loading.close()
    with _bar(title, transient=False) as tell:
        yield tell


@contextmanager
def _bar(title: str, *, transient: bool) -> Iterator[Progress]:
    """A bar without an end, until it is told of one; a transient one leaves nothing behind."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield quiet
        return

    from rich import progress as parts
    from rich.table import Column

    text = parts.TextColumn(
        "{task.fields[what]}", markup=False, table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis")
    )
    # what a command prints goes to its own output, not through the bar
    bar = parts.Progress(
        text, parts.BarColumn(24), parts.MofNCompleteColumn(), parts.TimeElapsedColumn(), console=console, expand=True,
        transient=transient, redirect_stdout=False, redirect_stderr=False,
    )  # fmt: skip
    task = bar.add_task(title, total=None, what=title)  # it moves to and fro until the first piece is told
    timer = Timer(max(0.0, _BEGAN + PATIENCE - time.monotonic()), bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda what, done, total: bar.update(task, completed=done, total=total, what=f"{title}: {what}")
        bar.update(task, what=title)
    finally:
        timer.cancel()
        timer.join()
        if bar.live.is_started:
            bar.stop()


def print_differences(differences: "Mapping[str, Difference]", units: str) -> None:
    """What a run differs by from the exact one: every function that moves, the pumps and the tip."""
    from polydraulic.display import as_shown, shown_unit
    from polydraulic.pages.text import text_table

    parts = list(dict.fromkeys(name.partition(".")[0] for name in differences))
    names = [f"{part}.{quantity}" for part in parts for quantity in ("angle", "position", "rate", "q_in", "p_in")]
    names += [*(f"{part}.p_pump" for part in parts), "effector.distance"]
    rows = []
    for name in (name for name in names if name in differences):
        d = differences[name]
        largest, rms, final = (f"{as_shown(value, d.unit, units):.4g}" for value in (d.largest, d.rms, d.final))
        unit = shown_unit(d.unit, units)
        rows.append(["tip" if name == "effector.distance" else name, largest, f"{d.time:.2f} s", rms, final, unit])
    print("differences from exact:")
    print("\n".join(text_table(("", "largest", "at", "rms", "at the end", "unit"), rows)))
