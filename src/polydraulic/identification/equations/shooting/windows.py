"""A log cut into windows from which a machine can be simulated: commands, what was measured, and what is known of the start.

Commands drive the pilots from the beginning of a piece on, so that spools need no sensor. Positions and rates at the start of a
window come from a parabola through the rows near it; pressures from their sensors, or from a run that leads in. Elsewhere a sensor may be
silent: what it reads is NaN there, and nothing is compared.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.log_pieces import even_pieces, in_si, raster_of
from polydraulic.identification.noise import noise_of_pieces
from polydraulic.parameters.layout.schema import LayoutMachine, position_columns
from polydraulic.simulation.layout.columns import circuit_keys, columns_of, cross_name, function_column, kept_quantities
from polydraulic.tables import Table

LONGEST_STEP = 5e-3  # s
LEAD = 1.0  # s of a piece before its first window: pilots have forgotten how it began
_NEAR = 0.1  # s before and after the start of a window
_LEAST_NOISE = 1e-12  # SI, of a sensor that never moves: what is left of runs is divided by it


class ComparedColumn(NamedTuple):
    """A column of the log that runs are compared with.

    Attributes
    ----------
    column : str
    noise : float, SI
        Standard deviation of its white noise.
    """

    column: str
    noise: float


class Windows(NamedTuple):
    """Windows of equal length.

    Attributes
    ----------
    dt : float, s
        Step of the simulation.
    every : int
        Steps for each row of the log.
    channels : tuple of ComparedColumn
    command : list of (n_step_of_piece, n_function) array, V
        Of each piece, at every step and without dead time.
    piece, first : (n_window,) array of int
        Which piece a window lies in, and at which of its steps it begins.
    n_step : int
    measured : (n_window, n_row, n_channel) array
        From the row after the start on; NaN where a sensor is silent.
    position, rate : (n_window, n_function) array
        At the start.
    lead_position, lead_rate : (n_window, n_function) array
        `LEAD` before it.
    position_sd, rate_sd : (n_function,) array
    p_a, p_b : (n_window, n_function) array, Pa
        At the start, where they are measured; NaN in windows where a sensor is silent then.
    time : (n_window,) array, s
        Of the start.
    """

    dt: float
    every: int
    channels: tuple[ComparedColumn, ...]
    command: list[np.ndarray]
    piece: np.ndarray
    first: np.ndarray
    n_step: int
    measured: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    lead_position: np.ndarray
    lead_rate: np.ndarray
    position_sd: np.ndarray
    rate_sd: np.ndarray
    p_a: np.ndarray | None
    p_b: np.ndarray | None
    time: np.ndarray


def sensors_of(machine: LayoutMachine, table: Table) -> list[str]:
    """Columns of a log that a run has, too, but for commands."""
    return [name for name in run_sensors(machine) if name in table.names]


def run_sensors(machine: LayoutMachine) -> list[str]:
    """Columns of a run that a sensor may read."""
    known = [
        function_column(machine, f.name, quantity, "").name
        for f in machine.functions
        for quantity in kept_quantities(f)
    ]
    known += [key for c in machine.circuits for key in circuit_keys(c, p_pump=True, stores_oil=False)]
    return [*known, *(cross_name(x.giving) for x in machine.crossovers)]


def cut_windows(machine: LayoutMachine, table: Table, sensors: Sequence[str], *, seconds: float, most: int) -> Windows:
    """Windows that follow each other, spread over the log where there are more than `most`.

    Parameters
    ----------
    machine : LayoutMachine
    table : Table
        The log, in SI; it may declare missing values.
    sensors : sequence of str
        Columns that runs are compared with.
    seconds : float
        Length of a window.
    most : int
        Windows.

    Raises
    ------
    InputError
        No command of a function, no position of one that moves, no piece that is long enough, or none in which positions are known where windows begin.
    """
    commands, joints, n = [f"{f}.voltage" for f in machine.names], position_columns(machine), len(machine.names)
    _check_columns(machine, table, [*commands, *joints])
    raster = raster_of(table)
    every = max(1, int(np.ceil(raster / LONGEST_STEP - 1e-9)))
    n_row, lead, near = max(1, round(seconds / raster)), int(np.ceil(LEAD / raster)), max(3, round(_NEAR / raster))
    pieces = even_pieces(table, commands, [*joints, *sensors])
    starts = _starts(pieces, slice(n, 2 * n), lead, near, n_row)
    if not starts:
        least = (lead + near + n_row + 1) * raster
        raise InputError(
            f"no piece of the log lasts {least:.4g} s without a gap, with positions of all functions where a window begins and {LEAD:g} s before; "
            "choose shorter windows"
        )
    if len(starts) > most:
        starts = [starts[i] for i in np.linspace(0, len(starts) - 1, most).round().astype(int)]
    noise = np.array([noise_of_pieces([values[:, k] for _, values in pieces]) for k in range(n, 2 * n + len(sensors))])
    noise = np.maximum(noise, _LEAST_NOISE)
    (position, rate), (lead_position, lead_rate) = (
        _parabolas([pieces[k][1][row - back - near : row - back + near + 1, n : 2 * n] for k, row in starts], raster)
        for back in (0, lead)
    )
    gain_position, gain_rate = _parabola_gain(near, raster)

    def at_start(port: str) -> np.ndarray | None:
        columns = [f"{f}.{port}" for f in machine.names]
        if not set(columns) <= set(sensors):
            return None
        places = [2 * n + list(sensors).index(c) for c in columns]
        return np.array([pieces[k][1][row, places] for k, row in starts])

    return Windows(
        dt=raster / every,
        every=every,
        channels=tuple(ComparedColumn(name, level) for name, level in zip(sensors, noise[n:].tolist(), strict=True)),
        command=[_steps(at, values[:, :n], raster, every) for at, values in pieces],
        piece=np.array([k for k, _ in starts]),
        first=np.array([row * every for _, row in starts]),
        n_step=n_row * every,
        measured=np.array([pieces[k][1][row + 1 : row + 1 + n_row, 2 * n :] for k, row in starts]),
        position=position,
        rate=rate,
        lead_position=lead_position,
        lead_rate=lead_rate,
        position_sd=noise[:n] * gain_position,
        rate_sd=noise[:n] * gain_rate,
        p_a=at_start("p_a"),
        p_b=at_start("p_b"),
        time=np.array([pieces[k][0][row] for k, row in starts]),
    )


def _check_columns(machine: LayoutMachine, table: Table, needed: Sequence[str]) -> None:
    """Refuse a log without commands and positions, or with columns in another unit."""
    missing = [name for name in ["time", *needed] if name not in table.names]
    if missing:
        raise InputError(
            f"the log has no column {missing[0]!r}: commands and positions of all functions are the least that is needed"
        )
    of_runs = {column.name: column.unit for column in columns_of(machine).columns}
    in_si(table, of_runs | dict.fromkeys((f"{f}.voltage" for f in machine.names), "V") | {"time": "s"})


def _starts(
    pieces: Sequence[tuple[np.ndarray, np.ndarray]], positions: slice, lead: int, near: int, n_row: int
) -> list[tuple[int, int]]:
    """Piece and row at which each window begins: as early as the one before and the positions near it, and `lead` before, allow."""
    found = list[tuple[int, int]]()
    for k, (at, values) in enumerate(pieces):
        known = ~np.isnan(values[:, positions]).any(axis=1)
        around = np.convolve(known, np.ones(2 * near + 1), mode="same") > 2 * near + 0.5
        following, end = lead + near, len(at) - n_row - 1
        for row in (np.flatnonzero(around[lead:] & around[:-lead]) + lead).tolist():
            if following <= row < end:
                found.append((k, row))
                following = row + n_row
    return found


def _steps(at: np.ndarray, command: np.ndarray, raster: float, every: int) -> np.ndarray:
    """Commands at every step of a piece: cubics that are monotone between its rows, since straight lines cut the corners of a hand."""
    from scipy.interpolate import PchipInterpolator

    if len(at) == 1:  # a row between two gaps
        return command
    fine = at[0] + raster / every * np.arange((len(at) - 1) * every + 1)
    return np.asarray(PchipInterpolator(at, command)(np.minimum(fine, at[-1])))


def _parabolas(stretches: Sequence[np.ndarray], raster: float) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes in the middle of stretches of rows, (n_stretch, n_column) each."""
    half = len(stretches[0]) // 2
    at = raster * np.arange(-half, half + 1)
    fits = np.array([np.polynomial.polynomial.polyfit(at, rows, 2) for rows in stretches])
    return fits[:, 0], fits[:, 1]


def _parabola_gain(half: int, raster: float) -> tuple[float, float]:
    """Standard deviations of value and slope for white noise of one."""
    at = raster * np.arange(-half, half + 1)
    design = np.vander(at, 3, increasing=True)
    covariance = np.linalg.inv(design.T @ design)
    return float(np.sqrt(covariance[0, 0])), float(np.sqrt(covariance[1, 1]))
