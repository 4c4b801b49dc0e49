"""What commands show while they work, and tables of what they found."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from polydraulic.progress import Progress

if TYPE_CHECKING:
    from polydraulic.simulation.trajectory import Difference

PATIENCE = 2.0  # s, before progress is shown


@contextmanager
def progress_bar(title: str) -> Iterator[Progress]:
    """A progress bar; what it gives is the `progress` of any function that takes long."""
    with _bar(title, 1) as update:
        yield lambda what, done, total: update(done, total, what)


@contextmanager
def _bar(title: str, total: int) -> Iterator[Callable[[int, int, str], None]]:
    """A progress bar that appears when the work takes longer than `PATIENCE`."""
    from threading import Timer

    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.fields[step]:40s}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total}"),
    )
    bar = Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True), transient=False)
    task = bar.add_task(title, total=total, step="")
    timer = Timer(PATIENCE, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda done, total, step: bar.update(task, completed=done, total=total, step=step)
    finally:
        timer.cancel()
        timer.join()
        if bar.live.is_started:
            bar.stop()


def print_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Texts in columns, the first to the left, the others to the right."""
    widths = [max(len(row[place]) for row in (heads, *rows)) for place in range(len(heads))]
    for first, *others in (heads, *rows):
        print(
            "  ".join(["  " + first.ljust(widths[0]), *(t.rjust(w) for t, w in zip(others, widths[1:], strict=True))])
        )


def print_differences(differences: "Mapping[str, Difference]") -> None:
    """What a run differs by from the exact one: every link that moves, the pumps and the tip."""
    from polydraulic.parameters.schema import LINKS
    from polydraulic.simulation.trajectory import field_unit
    from polydraulic.units import from_si

    names = [f"{link}.{quantity}" for link in LINKS for quantity in ("angle", "rate", "q_in", "p_in")]
    names += ["boom.p_pump", "series.p_pump", "effector.distance"]
    print(f"{'differences from exact':24s}{'largest':>12s}{'at':>10s}{'rms':>12s}{'at the end':>12s}")
    for name in (name for name in names if name in differences):
        d = differences[name]
        tip = name == "effector.distance"
        unit = "mm" if tip else field_unit(name, d.unit)
        largest, rms, final = (f"{from_si(value, unit):12.4g}" for value in (d.largest, d.rms, d.final))
        print(f"  {'tip' if tip else name:22s}{largest}{d.time:8.2f} s{rms}{final} {unit}")
