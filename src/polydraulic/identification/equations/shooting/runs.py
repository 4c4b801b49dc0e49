"""Windows of a log simulated from given states, all side by side, and the slopes of what comes out.

A machine whose number is a little different runs through all windows at once in lanes; so does one whose windows all begin with a little more of
one quantity, since windows do not see each other. One batch per number, and one for all quantities of the start, give all slopes.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.inertia import inertial_numbers, inertial_values, torque_regressor
from polydraulic.identification.equations.mechanics.motion_rows import oil_torques
from polydraulic.identification.equations.shooting.windows import LEAD, Windows
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.batch.batch import simulate_batch
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import start_from

PRESSURE_STEP, POSITION_STEP, RATE_STEP = 1e4, 1e-5, 1e-4  # Pa, rad or m, rad/s or m/s
NUMBER_STEP = 1e-3  # of a number's spread
_DRIVES = re.compile(r"\.pilot\.|\.knots\[")  # numbers that spools follow from
_ABOVE_RETURN = 2e5  # Pa, in the line that does not carry


class Driven(NamedTuple):
    """What commands do: spools where windows begin, (n_window, n_function) in m, voltages at the pilots, (n_window, n_step, n_function)."""

    spool: np.ndarray
    voltage: np.ndarray


class Slopes(NamedTuple):
    """Slopes of all channels in all rows of all windows.

    Attributes
    ----------
    numbers : (n_window, n_row, n_channel, n_number) array
    states : (n_window, n_row, n_channel, 4 n_function) array
        Over pressures at A and B, positions and rates at the start.
    """

    numbers: np.ndarray
    states: np.ndarray


def shoot(
    machine: LayoutMachine, windows: Windows, states: np.ndarray, driven: Driven | None = None
) -> np.ndarray | None:
    """What sensors would read, (n_window, n_row, n_channel); None where a run diverges.

    Parameters
    ----------
    machine : LayoutMachine
    windows : Windows
    states : (n_window, 4 n_function) array
        Pressures at A and B, positions and rates at the start.
    driven : Driven, optional
        Of this machine, where it is known already.
    """
    spool, voltage = driven or driven_windows(machine, windows)
    batch = simulate_batch(
        machine,
        "exact",
        voltage,
        dt=windows.dt,
        x0=_vectors(machine, spool, states),
        keep=["rows"],
        columns=[channel.column for channel in windows.channels],
        every=windows.every,
    )
    assert batch.rows is not None
    rows = batch.rows[:, 1:]
    return rows if np.isfinite(rows).all() else None


def first_states(machine: LayoutMachine, windows: Windows) -> np.ndarray:
    """States at the start of the windows, (n_window, 4 n_function): what is measured, and pressures from a run that leads in."""
    if windows.p_a is not None and windows.p_b is not None and not np.isnan([windows.p_a, windows.p_b]).any():
        return np.hstack([windows.p_a, windows.p_b, windows.position, windows.rate])
    lead = round(LEAD / windows.dt)
    p_a, p_b = _resting(machine, windows.lead_position)
    spool, voltage = _driven(machine, windows, windows.first - lead, lead)
    names = machine.names
    batch = simulate_batch(
        machine,
        "exact",
        voltage,
        dt=windows.dt,
        x0=_vectors(machine, spool, np.hstack([p_a, p_b, windows.lead_position, windows.lead_rate])),
        columns=[f"{f}.{p}" for p in ("p_a", "p_b") for f in names],
    )
    led = np.where(np.isfinite(batch.final), batch.final, np.hstack([p_a, p_b]))
    for k, known in enumerate((windows.p_a, windows.p_b)):
        if known is not None:
            own = slice(k * len(names), (k + 1) * len(names))
            led[:, own] = np.where(np.isnan(known), led[:, own], known)
    return np.hstack([led, windows.position, windows.rate])


def window_slopes(
    machine: LayoutMachine,
    windows: Windows,
    states: np.ndarray,
    here: np.ndarray,
    paths: Sequence[str],
    spread: np.ndarray,
) -> Slopes | None:
    """Slopes by differences, one batch for each number and each quantity of the start; None where a run diverges.

    Parameters
    ----------
    machine, windows, states
        As for `shoot`.
    here : (n_window, n_row, n_channel) array
        What it gives.
    paths : sequence of str
    spread : (n,) array
        Of these numbers, a thousandth of which is the step.
    """
    of_numbers, driven = np.empty((*here.shape, len(paths))), driven_windows(machine, windows)
    values = {number.path: number.value for number in machine.numbers}
    for k, path in enumerate(paths):
        step = NUMBER_STEP * float(spread[k])
        there = None
        for way in (step, -step):  # the other way where a condition between numbers is in the way
            try:
                other = machine.with_values({path: values[path] + way})
            except InputError:
                continue
            there = shoot(other, windows, states, None if _DRIVES.search(path) else driven)
            if there is not None:
                of_numbers[..., k] = (there - here) / way
                break
        if there is None:
            return None
    steps = np.repeat([PRESSURE_STEP, PRESSURE_STEP, POSITION_STEP, RATE_STEP], len(machine.names))
    moved = (states[None] + np.diag(steps)[:, None]).reshape(-1, len(steps))  # one after the other, all windows of each
    there = shoot(
        machine, windows, moved, Driven(*(np.tile(part, (len(steps), *[1] * (part.ndim - 1))) for part in driven))
    )
    if there is None:
        return None
    of_states = np.moveaxis(there.reshape(len(steps), *here.shape) - here, 0, -1) / steps
    return Slopes(of_numbers, of_states)


def driven_windows(machine: LayoutMachine, windows: Windows) -> Driven:
    """Spools and voltages of all windows."""
    return _driven(machine, windows, windows.first, windows.n_step)


def commanded_travel(machine: LayoutMachine, windows: Windows) -> dict[str, float]:
    """Largest travel that commands drive each spool to in all pieces, m."""
    return {
        f.name: max(float(np.abs(_followed(f, command[:, k], windows.dt)).max()) for command in windows.command)
        for k, f in enumerate(machine.functions)
    }


def _driven(machine: LayoutMachine, windows: Windows, first: np.ndarray, n_step: int) -> Driven:
    spool = np.empty((len(first), len(machine.functions)))
    voltage = np.empty((len(first), n_step, len(machine.functions)))
    inside = first[:, None] + np.arange(n_step)
    for number, command in enumerate(windows.command):
        mine = np.flatnonzero(windows.piece == number)
        at = np.arange(len(command)) * windows.dt
        for k, f in enumerate(machine.functions):
            late = np.interp(at - f.pilot.dead_time, at, command[:, k])
            spool[mine, k] = _followed(f, late, windows.dt)[first[mine]]
            voltage[mine, :, k] = late[inside[mine]]
    return Driven(spool, voltage)


def _followed(f: MachineFunction, late: np.ndarray, dt: float) -> np.ndarray:
    """Spool at the beginning of each step, (n_step,) in m, from voltages behind the dead time."""
    from scipy.signal import lfilter

    travel = f.valve.knots[-1]
    target = np.clip(f.pilot.gain * late, -travel, travel)
    decay = np.exp(-dt / f.pilot.time_constant)
    after = lfilter([1.0 - decay], [1.0, -decay], target, zi=[decay * target[0]])[0]
    return np.append(target[0], after[:-1])


def _vectors(machine: LayoutMachine, spool: np.ndarray, states: np.ndarray) -> np.ndarray:
    """States as vectors, with pressures that lines can have and positions between the stops."""
    n = len(machine.functions)
    stops = np.array([f.stops for f in machine.functions])
    relief = np.array([f.line.relief for f in machine.functions])
    p_a, p_b = (np.clip(states[:, k * n : (k + 1) * n], machine.tank.floor, relief) for k in (0, 1))
    position = np.clip(states[:, 2 * n : 3 * n], stops[:, 0], stops[:, 1])
    measured = np.hstack([spool, p_a, p_b, position, states[:, 3 * n :]])
    if columns_of(machine).n_state == measured.shape[1]:
        return measured
    return np.array([start_from(machine, row) for row in measured])


def _resting(machine: LayoutMachine, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pressures at A and B that carry the weight of joints at rest, (n_window, n_function) each."""
    numbers, zero = inertial_numbers(machine), np.zeros_like(position)
    weight = torque_regressor(machine, numbers, position, zero, zero, machine.gravity) @ inertial_values(
        machine, numbers
    )
    lever_a = oil_torques(machine, position, zero + 1.0, zero)
    lever_b = -oil_torques(machine, position, zero, zero + 1.0)
    low = machine.tank.return_pressure + _ABOVE_RETURN
    p_a = (weight + lever_b * low) / lever_a
    p_b = (lever_a * low - weight) / lever_b
    return np.where(p_a > low, p_a, low), np.where(p_a > low, low, p_b)
