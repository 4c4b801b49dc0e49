"""A machine run against a log of the real one: how far joints drift over windows restarted from the measured state.

The joysticks of the log drive it; nothing else of the log is seen after the start of a window. What is judged is the whole machine,
flow model and parameter set (masses, friction, lines) together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel, build_flow, layout_flow
from polydraulic.identification.arguments import models_of, parts_of, table_of, unused_in_words
from polydraulic.identification.doubts.channels import channel_doubts
from polydraulic.identification.log_pieces import check_rises
from polydraulic.identification.log_rows import MACHINE_UNITS
from polydraulic.identification.plausible import check_functions, check_plausible
from polydraulic.machine.reach.tip import tip_at_joints
from polydraulic.networks.model.model import Model
from polydraulic.pages.text import text_table
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet
from polydraulic.simulation.batch.batch import simulate_batch
from polydraulic.simulation.layout.columns import function_column
from polydraulic.simulation.layout.prepare import start_from
from polydraulic.tables import Table, began

SECONDS = 10.0
DRIFT_HEADS = ("joint", "median", "largest", "moved")
DT = 5e-3  # s
_BRIDGED = 0.1  # s without a row that straight lines bridge: half the time constant of a spool
_NEAR = 0.1  # s before and after the start, whose rows give angle and rate at the start
_ROWS_NEAR = 5
_DECIMALS = {"deg": 2, "rad": 4, "mm": 0, "in": 1, "m": 3}
_NAMED = 6  # columns in an error
_LEFT = 0.1  # share of rows in no window, above which it is worth a word


class Joint(NamedTuple):
    """Where a function's joint stands in a log.

    Attributes
    ----------
    function : str
    column : str
        ``NAME.angle``, or ``NAME.position`` of a joint that slides.
    unit : str
        Rad or m.
    dead_time : float, s
        Of the pilot.
    """

    function: str
    column: str
    unit: str
    dead_time: float


class Window(NamedTuple):
    """One window.

    Attributes
    ----------
    time : (n_row,) array, s
        Of the log.
    measured, run : (n_row, n_function) array, rad or m
        Positions of joints in the order of the functions; nan from where a run diverges.
    """

    time: np.ndarray
    measured: np.ndarray
    run: np.ndarray


class Drift(NamedTuple):
    """How far a joint, or the tip, is from the measured one.

    Attributes
    ----------
    name : str
    unit : str
        SI unit of the numbers.
    median, largest : float
        Of the windows' largest distances; infinite where a run diverges.
    moved : float
        Median of how far the measured one moves in a window.
    """

    name: str
    unit: str
    median: float
    largest: float
    moved: float


@dataclass(frozen=True, eq=False)
class Replay:
    """A machine run against a log; ``str()`` says how far it drifts.

    Attributes
    ----------
    windows : list of Window
    drifts : list of Drift
        Of each function's joint, and of the tip.
    seconds : float
        Length of a window.
    began : float, s since 1970
        When the log's time was zero; 0 if that is not known, or its times are dates themselves.
    doubts : tuple of str
        Rows that are not used; channels of the log that contradict each other, whatever the machine does.
    """

    windows: list[Window] = field(repr=False)
    drifts: list[Drift]
    seconds: float
    began: float = 0.0
    doubts: tuple[str, ...] = ()

    def text(self, units: str = DEFAULT) -> str:
        """How far it drifts, in a table."""
        head = (
            f"{len(self.windows)} windows of {self.seconds:g} s, each started from the measured state; "
            "largest distance in a window:"
        )
        doubts = [f"warning: {doubt}" for doubt in self.doubts]
        return "\n".join([*doubts, head, *text_table(DRIFT_HEADS, drift_rows(self.drifts, units))])

    def __str__(self) -> str:
        return self.text()


def replay(
    log: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine | str | Path = "cat215b",
    flow: str | FlowModel = "polynomial",
    *,
    models: Sequence[Model] | str | Path | None = None,
    seconds: float = SECONDS,
    dt: float = DT,
    rows: np.ndarray | None = None,
    progress: Progress = quiet,
) -> Replay:
    """Run a machine over windows of a log of the real one, each started from the measured state.

    Angle and rate at the start come from a parabola through the rows within 0.1 s of it, spools and pressures from its row.
    Windows follow each other; gaps of up to 0.1 s are bridged by straight lines, longer ones end a piece.

    Parameters
    ----------
    log : Table, str, Path or sequence of them
        Or its file: ``time`` and ``NAME.voltage``, ``NAME.angle`` (``NAME.position`` of a joint that slides), ``NAME.spool``, ``NAME.p_a``,
        ``NAME.p_b`` of every function, in SI.
        Of several tables, or a pattern such as ``day*.parquet``, no window crosses the end of one.
    machine : LayoutMachine, str or Path
        Or a parameter set by its name or file. What declared effects keep and no sensor reads (play, hysteresis) begins as
        pressures and spools suggest.
    flow : str or flow model
        As for `simulate`; it must serve all functions.
    models : sequence of Model, str or Path, optional
        Networks for the flow models ``"polynomial"`` and ``"neural"``, or their file; if not given those of the package, which are for the
        layout of cat215b.
    seconds : float
        Length of a window.
    dt : float, s
        Time step of the run.
    rows : (n_row,) array of bool, optional
        Which rows may be in a window; all if not given.
    progress : Progress, optional

    Returns
    -------
    Replay

    Raises
    ------
    InputError
        A column is missing, in another unit or beyond all that the machine can do, times that do not rise, a window of no length, no piece of the log as long as a window,
        models of another flow model, or a flow model that does not serve all functions.
    """
    if models is not None and flow not in ("polynomial", "neural"):
        raise InputError(f"models go with the flow models 'polynomial' and 'neural', not with {flow!r}")
    plant = as_machine(machine)
    needed = driven(plant)
    table, source = table_of(log, ["time"], needed)
    check_functions(plant, table)
    if missing := [name for name in needed if name not in table.names]:
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        raise InputError(
            f"{source}: no column {', '.join(map(repr, missing[:_NAMED]))}{more}; a replay needs time and, of each of "
            f"{', '.join(plant.names)}, voltage, angle (position of a joint that slides), spool, p_a and p_b"
        )
    check_plausible(plant, table)
    if isinstance(flow, str):
        flow = build_flow(flow, plant, **({} if models is None else {"models": models_of(models)}))
    flow = layout_flow(flow, plant)
    if idle := [f for f in plant.names if f not in flow.served]:
        raise InputError(
            f"flow {flow.name!r} has no networks for {', '.join(idle)}; train networks of their circuits, too"
        )
    windows = replayed(plant, flow, table, seconds=seconds, dt=dt, rows=rows, progress=progress)
    if not windows:
        raise InputError(f"{source}: no piece of {seconds:g} s without a gap; choose shorter windows")
    doubts = (unused_in_words(table), _between_windows(table, windows), *(d.text for d in channel_doubts(plant, table)))
    return Replay(windows, drifts(plant, windows), seconds, began(table), tuple(said for said in doubts if said))


def _between_windows(log: Table, windows: Sequence[Window]) -> str:
    """Sentence on rows of the log that are in no window, if these are many; empty otherwise."""
    left = len(log) - sum(len(window.time) for window in windows)
    if left <= _LEFT * len(log):
        return ""
    return f"{left} of {len(log)} rows are in no window: they lie in pieces without a gap, or at ends of these, that are shorter than one"


def joints_of(machine: LayoutMachine) -> list[Joint]:
    """Joints of a machine's functions, in their order."""
    return [
        Joint(f.name, *function_column(machine, f.name, "angle", "rad"), f.pilot.dead_time) for f in machine.functions
    ]


def driven(machine: LayoutMachine) -> list[str]:
    """Columns besides ``time`` that a machine is run against."""
    joints = joints_of(machine)
    compared = [name for joint in joints for name in (f"{joint.function}.voltage", joint.column)]
    return [*compared, *(f"{joint.function}.{what}" for joint in joints for what in ("spool", "p_a", "p_b"))]


def replayed(
    machine: LayoutMachine,
    flow: str | FlowModel,
    log: Table,
    *,
    seconds: float = SECONDS,
    dt: float = DT,
    rows: np.ndarray | None = None,
    progress: Progress = quiet,
) -> list[Window]:
    """Windows of `replay`; none where no piece of the log is long enough."""
    for name in ("time", *driven(machine)):
        si = MACHINE_UNITS[name.split(".")[-1]]
        if len(log[name]) and log.unit(name) not in ("", si):
            raise InputError(f"column {name!r} is in {log.unit(name)!r}; a machine runs in SI, this in {si!r}")
    if not 0.0 < dt < np.inf:
        raise InputError(f"dt = {dt:g} s: must be a positive number of seconds; {DT:g} s is usual")
    if not dt * 2 <= seconds < np.inf:
        raise InputError(f"a window of {seconds:g} s: must be finite and two time steps of {dt:g} s at least")
    time = log["time"]
    check_rises(time)
    begins = _begins(time, np.ones(len(time), dtype=bool) if rows is None else rows, seconds, parts_of(log))
    if not begins:
        return []
    joints, n_step = joints_of(machine), round(seconds / dt)
    voltage, x0 = np.empty((len(begins), n_step, len(joints))), []
    for number, begin in enumerate(begins):
        at = time[begin] + np.arange(n_step) * dt
        own = _part_with(parts_of(log), begin)
        for place, joint in enumerate(joints):
            voltage[number, :, place] = np.interp(
                at - joint.dead_time, time[own], log[f"{joint.function}.voltage"][own]
            )
        state = _state(log, begin, own, joints)
        x0.append(start_from(machine, state))
    columns = [joint.column for joint in joints]
    # after the dead time
    batch = simulate_batch(
        machine, flow, voltage, dt=dt, x0=np.array(x0), keep=["rows"], columns=columns, progress=progress
    )
    windows = []
    for number, begin in enumerate(begins):
        inside = slice(begin, int(np.searchsorted(time, time[begin] + seconds - 0.5 * dt)))
        run = [np.interp(time[inside] - time[begin], batch.time, batch[name][number]) for name in columns]
        windows.append(Window(time[inside], log.matrix(columns)[inside], np.column_stack(run)))
    return windows


def drifts(machine: LayoutMachine, windows: list[Window]) -> list[Drift]:
    """How far joints (rad, m) and tip (m) drift in windows."""
    apart = [np.abs(window.run - window.measured).max(axis=0) for window in windows]
    moved = [np.ptp(window.measured, axis=0) for window in windows]
    tips = [[tip_at_joints(machine, positions) for positions in (w.measured, w.run)] for w in windows]
    tip_apart = [np.linalg.norm(run - measured, axis=1).max() for measured, run in tips]
    tip_moved = [np.linalg.norm(measured - measured[0], axis=1).max() for measured, _ in tips]
    found = []
    for name, unit, far, way in [
        *((j.function, j.unit, np.array(apart)[:, k], np.array(moved)[:, k]) for k, j in enumerate(joints_of(machine))),
        ("tip", "m", np.array(tip_apart), np.array(tip_moved)),
    ]:
        far = np.nan_to_num(far, nan=np.inf)
        found.append(Drift(name, unit, float(np.median(far)), float(far.max()), float(np.median(way))))
    return found


def drift_rows(found: Sequence[Drift], units: str = DEFAULT) -> list[list[str]]:
    """Texts under `DRIFT_HEADS`."""
    rows = []
    for drift in found:
        unit = shown_unit(drift.unit, units)
        values = (as_shown(value, drift.unit, units) for value in (drift.median, drift.largest, drift.moved))
        rows.append([drift.name, *("diverged" if v == np.inf else f"{v:.{_DECIMALS[unit]}f} {unit}" for v in values)])
    return rows


def against_log(machine: LayoutMachine, flow: str | FlowModel, log: Table, rows: np.ndarray) -> tuple[str, list[Drift]]:
    """How far joints and tip drift in the rows of a log that were held out, and in words over what; or why that is not known.

    Parameters
    ----------
    machine : LayoutMachine
    flow : flow model
        Learnt without these rows.
    log : Table
        As for `replay`; it may lack voltages and angles.
    rows : (n_row,) array of bool
        Held out.
    """
    missing = [name for name in driven(machine) if name not in log.names]
    if missing:
        return f"not run against the log: it has no {missing[0]}", []
    windows = replayed(machine, flow, log, rows=rows)
    if not windows:
        return f"not run against the log: no piece of {SECONDS:g} s without a gap in the blocks held out", []
    return (
        f"run against the log: {len(windows)} windows of {SECONDS:g} s in the blocks held out, each started from the measured state, by "
        "networks learnt without them",
        drifts(machine, windows),
    )


def _begins(time: np.ndarray, rows: np.ndarray, seconds: float, parts: Sequence[int]) -> list[int]:
    """First rows of windows that follow each other in pieces without a long gap, each in one of the parts, numbers of rows."""
    allowed = np.flatnonzero(rows)
    if not allowed.size:
        return []
    part, lost = np.repeat(np.arange(len(parts)), parts)[allowed], _rounding(time)
    gap = np.diff(time[allowed]) > _BRIDGED + lost
    cuts = np.flatnonzero((np.diff(allowed) > 1) | gap | (np.diff(part) > 0)) + 1
    found = []
    for piece in np.split(allowed, cuts):
        last, own = time[piece[-1]], _part_with(parts, piece[0])
        earliest = time[piece[0]]
        for row in piece.tolist():
            if time[row] + seconds > last + lost:
                break
            if time[row] >= earliest - lost and len(_near(time, row, own)) >= _ROWS_NEAR:
                found.append(row)
                earliest = time[row] + seconds
    return found


def _part_with(parts: Sequence[int], row: int) -> slice:
    """Rows of the part, of parts with this many rows, that a row is in."""
    ends = np.cumsum([0, *parts]).tolist()
    part = int(np.searchsorted(ends, row, side="right")) - 1
    return slice(ends[part], ends[part + 1])


def _near(time: np.ndarray, row: int, own: slice) -> np.ndarray:
    """Rows of a part of the log that are near to a row in time."""
    reach = _NEAR + _rounding(time)
    low, high = np.searchsorted(time[own], [time[row] - reach, time[row] + reach])
    return np.arange(low, high) + own.start


def _rounding(time: np.ndarray) -> float:
    """What rounding may take from differences of rising times, s: those since 1970 are known to a quarter of a microsecond."""
    return max(1e-9, 4.0 * float(np.spacing(np.abs(time[[0, -1]]).max())))


def _state(log: Table, row: int, own: slice, joints: Sequence[Joint]) -> np.ndarray:
    """Measured state in a row, (5 n_function,), from rows of the part of the log that it is in."""
    near = _near(log["time"], row, own)
    t = log["time"][near] - log["time"][row]
    fits = [np.polyfit(t, log[joint.column][near], 2) for joint in joints]
    values = [log[f"{joint.function}.{what}"][row] for what in ("spool", "p_a", "p_b") for joint in joints]
    values[len(joints) :] = [max(value, 0.0) for value in values[len(joints) :]]
    return np.array([*values, *(fit[2] for fit in fits), *(fit[1] for fit in fits)])
