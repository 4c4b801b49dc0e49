"""What a log says of each function of a machine: which sensors it has, signals in SI, how noisy they are, and what is missing for what."""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.noise import noise_level
from polydraulic.identification.equations.parabolas import ROWS as SMOOTHED
from polydraulic.identification.equations.parabolas import local_parabolas
from polydraulic.identification.equations.pilot_fit import PilotFit, fit_pilot, moves_against, smooth_spool
from polydraulic.identification.plausible import position_column
from polydraulic.machine.volumes import levers, side_volumes
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table


class Signals(NamedTuple):
    """What sensors read of a function; None where there is no sensor.

    Attributes
    ----------
    spool : (n_row,) array, m
        From the sensor, and from the pilot where its voltage is known.
    p_a, p_b : (n_row,) array, Pa
    q_in, q_out : (n_row,) array, m3/s
    volume_a, volume_b : (n_row,) array, m3
        That the joint's position gives the two sides of the actuator.
    noise : dict
        Standard deviation of each of these, in SI; of `spool` of what is left of it.
    pilot : PilotFit or None
    scale : float
        Standard error of the scale of `spool`, relative: what the pilot drives is as wrong as its gain.
    """

    spool: np.ndarray | None
    p_a: np.ndarray | None
    p_b: np.ndarray | None
    q_in: np.ndarray | None
    q_out: np.ndarray | None
    volume_a: np.ndarray | None
    volume_b: np.ndarray | None
    noise: dict[str, float]
    pilot: PilotFit | None
    scale: float = 0.0


def read_function(
    machine: LayoutMachine, f: MachineFunction, table: Table, segment: np.ndarray, fits_pilot: bool
) -> Signals:
    """Signals of a function.

    Parameters
    ----------
    machine : LayoutMachine
    f : MachineFunction
    table : Table
        The log, in SI.
    segment : (n_row,) array
    fits_pilot : bool
        Whether the pilot is to be found from the log; otherwise it is that of the machine.
    """

    def column(what: str) -> np.ndarray | None:
        name = f"{f.name}.{what}"
        return table[name] if name in table.names else None

    found = {what: column(what) for what in ("spool", "p_a", "p_b", "q_in", "q_out", "voltage")}
    noise = {what: noise_level(values, segment) for what, values in found.items() if values is not None}
    spool, voltage, pilot, scale = found["spool"], found["voltage"], None, 0.0
    travel = f.valve.knots[-1]
    if spool is not None and voltage is not None:
        pilot = fit_pilot(table["time"], segment, voltage, spool, travel, f.pilot)
        if pilot is not None:
            own = pilot.pilot if fits_pilot else f.pilot
            scale = pilot.errors.gain / own.gain if fits_pilot else 0.0
            spool, noise["spool"] = smooth_spool(own, travel, table["time"], segment, voltage, spool, noise["spool"])
    place = position_column(machine, f)
    volume_a = volume_b = None
    if place in table.names:
        position = local_parabolas(table[place], segment)[0]
        noise["position"] = noise_level(position, segment)
        volume_a, volume_b = side_volumes(machine, f, position)
        middle = levers(machine, f, position)
        noise["volume_a"], noise["volume_b"] = (
            noise_level(table[place], segment) / np.sqrt(0.5 * SMOOTHED) * float(np.mean(side)) for side in middle
        )
    p_a, p_b = found["p_a"], found["p_b"]
    return Signals(
        spool,
        None if p_a is None else np.maximum(p_a, 0.0),
        None if p_b is None else np.maximum(p_b, 0.0),
        found["q_in"],
        found["q_out"],
        volume_a,
        volume_b,
        noise,
        pilot,
        scale,
    )


def against_spools(machine: LayoutMachine, table: Table, segment: np.ndarray) -> list[str]:
    """Functions whose spool follows the voltage of the other sign: what such a voltage drives goes the wrong way."""
    return [
        f.name
        for f in machine.functions
        if {voltage := f"{f.name}.voltage", spool := f"{f.name}.spool"} <= set(table.names)
        and moves_against(table["time"], segment, table[voltage], table[spool], f.valve.knots[-1], f.pilot)
    ]


def missing_for_circuit(machine: LayoutMachine, functions: tuple[str, ...], signals: dict[str, Signals]) -> str:
    """Why a circuit cannot be fitted, in words; empty if it can."""
    lacks = [
        f"{name}.{what}"
        for name in functions
        for what in ("spool", "p_a", "p_b")
        if getattr(signals[name], what) is None
    ]
    for name in functions:
        if signals[name].q_in is None and signals[name].volume_a is None:
            lacks.append(f"{name}.q_in or {position_column(machine, machine.function(name))}")
    return f"the log has no {', '.join(lacks)}" if lacks else ""
