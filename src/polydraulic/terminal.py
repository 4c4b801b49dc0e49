"""What commands show while they work, and a table of what they found."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from polydraulic.progress import Progress

if TYPE_CHECKING:
    from polydraulic.simulation.trajectory import Difference

PATIENCE = 2.0  # s, before progress is shown


@contextmanager
def progress_bar(title: str, *, patience: float = PATIENCE) -> Iterator[Progress]:
    """A progress bar; what it gives is the `progress` of any function that takes long."""
    with _bar(title, 1, patience) as update:
        yield lambda what, done, total: update(done, total, what)


@contextmanager
def _bar(title: str, total: int, patience: float) -> Iterator[Callable[[int, int, str], None]]:
    """A progress bar that appears when the work takes longer than `patience` seconds."""
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
    timer = Timer(patience, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda done, total, step: bar.update(task, completed=done, total=total, step=step)
    finally:
        timer.cancel()
        timer.join()
        if bar.live.is_started:
            bar.stop()


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
