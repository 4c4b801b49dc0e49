"""How far a machine drifts from its log, run on the joysticks alone over windows of several lengths, before and after an identification."""

from typing import NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, amount
from polydraulic.identification.arguments import whole_rows
from polydraulic.identification.equations.identify import Identification
from polydraulic.identification.log_replay import Drift, drifts, driven, replayed
from polydraulic.progress import Progress, quiet

LENGTHS = (1.0, 5.0, 10.0, 30.0)  # s
FREE_RUN_HEADS = (
    "window",
    "windows",
    "of",
    "moved",
    "before: median",
    "before: largest",
    "after: median",
    "after: largest",
)
_LAST = 0.2  # of the log's time, over which it is run


class FreeRun(NamedTuple):
    """Drifts of one length of window, in SI."""

    seconds: float
    windows: int
    before: list[Drift]
    after: list[Drift]


def free_runs(found: Identification, *, progress: Progress = quiet) -> tuple[list[FreeRun], str]:
    """Runs over the last fifth of the log, and why there are none where there are none.

    Parameters
    ----------
    found : Identification
    progress : Progress, optional
    """
    missing = [name for name in driven(found.machine) if name not in found.table.names]
    if missing:
        return [], f"not run against the log: it has no {missing[0]}"
    if not found.table.known(driven(found.machine)).any():
        return [], "not run against the log: it has no row in which all sensors read something"
    log = whole_rows(found.table, ["time", *driven(found.machine)])
    time = log["time"]
    rows = time >= time[0] + (1.0 - _LAST) * (time[-1] - time[0])
    runs = []
    for number, seconds in enumerate(LENGTHS):
        progress(f"run against the log, {seconds:g} s", number, len(LENGTHS))
        pair = [replayed(m, "exact", log, seconds=seconds, rows=rows) for m in (found.before, found.machine)]
        if pair[0]:
            runs.append(FreeRun(seconds, len(pair[0]), drifts(found.before, pair[0]), drifts(found.machine, pair[1])))
    return runs, "" if runs else "not run against the log: no piece without a gap is long enough"


def free_run_rows(runs: list[FreeRun], units: str = DEFAULT) -> list[list[str]]:
    """Texts under `FREE_RUN_HEADS`."""

    def shown(value: float, unit: str) -> str:
        return amount(value, unit, units, digits=3) if np.isfinite(value) else "diverged"

    return [
        [
            f"{run.seconds:g} s",
            str(run.windows),
            b.name,
            *(shown(v, b.unit) for v in (b.moved, b.median, b.largest, a.median, a.largest)),
        ]
        for run in runs
        for b, a in zip(run.before, run.after, strict=True)
    ]
