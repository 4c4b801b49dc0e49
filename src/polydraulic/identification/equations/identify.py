"""A machine identified from a log of its work: curves, pumps, pilots, masses and friction inside the equations that are known.

Ways, each where the log has the sensors for it (`ways`): pilots, and what spools do besides, from voltages and spools; circuits from spools,
pressures and flows; masses and friction from pressures and positions, and whether it holds; what is left through simulation. All else keeps its
value and is named, with the reason.
"""

import hashlib
from collections.abc import Callable, Collection, Container, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.identification.arguments import table_of
from polydraulic.identification.doubts.channels import channel_doubts
from polydraulic.identification.doubts.stuck import without_stuck
from polydraulic.identification.equations.circuits import CircuitFound
from polydraulic.identification.equations.finished import Finished
from polydraulic.identification.equations.free_numbers import HOLDS, Freedom, freedom, is_effect
from polydraulic.identification.equations.identified_file import Identified, file_text, machine_data, with_found
from polydraulic.identification.equations.mechanics.fit import MechanicsFit
from polydraulic.identification.equations.pilot_fit import PilotFit
from polydraulic.identification.equations.sensors import Signals, against_spools, read_function
from polydraulic.identification.equations.shooting.fit import ShootingFit
from polydraulic.identification.equations.shooting.windows import run_sensors
from polydraulic.identification.equations.ways.by_flows import (
    LEAST_ROWS,
    find_circuits,
    refused_circuits,
    take_curves,
)
from polydraulic.identification.equations.ways.by_pressures import find_mechanics
from polydraulic.identification.equations.ways.by_rest import find_holding
from polydraulic.identification.equations.ways.by_runs import entries_left, find_left, lacking_for_runs
from polydraulic.identification.equations.ways.by_spools import (
    SpoolFound,
    declared_effects,
    find_pilots,
    look_at_spools,
    smoothed_again,
    take_effects,
)
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.identification.equations.words import lines_of
from polydraulic.identification.log_pieces import check_rises, raster_segments, raster_within
from polydraulic.identification.log_rows import check_one_raster
from polydraulic.identification.plausible import check_functions, check_plausible, check_units
from polydraulic.networks.blas_threads import one_blas_thread
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import load_machine, machine_path
from polydraulic.progress import Progress, quiet
from polydraulic.tables import MISSING, Table

_RUN_STEPS, _CIRCUIT_STEPS = 75, 20  # of a progress bar, for simulation, and for a circuit
_TURNS = 3  # of spools and circuits, where jets push spools: each knows the jets from the one before


@dataclass(frozen=True, eq=False)
class Identification:
    """A machine identified from a log; ``str()`` says what was found.

    Attributes
    ----------
    machine, before : LayoutMachine
        With what was found, and as it was given.
    changes : dict from path to Identified
        New values of entries of the machine file, with standard errors, in SI.
    circuits : dict from name to CircuitFound
        Those that were fitted.
    pilots : dict from function to PilotFit
    mechanics : MechanicsFit or None
        Masses and friction by regression.
    runs : ShootingFit or None
        What was left to simulation.
    kept : list of str
        What kept its value, and why.
    remarks : list of str
        What is determined, and what is not.
    freedom : Freedom
        What was allowed to change.
    table : Table
        The log.
    source : str
        What the log is called.
    """

    machine: LayoutMachine
    before: LayoutMachine
    changes: dict[str, Identified]
    circuits: dict[str, CircuitFound]
    pilots: dict[str, PilotFit]
    mechanics: MechanicsFit | None
    runs: ShootingFit | None
    kept: list[str]
    remarks: list[str]
    freedom: Freedom
    table: Table = field(repr=False)
    source: str
    data: dict[str, Any] = field(repr=False)

    def text(self, units: str = DEFAULT) -> str:
        """What was found, in lines."""
        return "\n".join(lines_of(self, units))

    def __str__(self) -> str:
        return self.text()

    def write(self, path: str | Path) -> None:
        """Write the machine as a TOML file, whole or not at all.

        Parameters
        ----------
        path : str or Path
            ``.toml``.
        """
        toml_ending(path)
        head = [f"{self.before.title}, identified from {self.source} by `polydraulic identify`.", *self.kept]
        write_text(path, file_text(with_found(self.data, self.machine), self.changes, head))


def toml_ending(path: str | Path) -> None:
    """Refuse another ending than that of machine files."""
    if Path(path).suffix.lower() != ".toml":
        raise InputError(f"{path}: a machine file ends in .toml")


def identify(
    log: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine | str | Path,
    *,
    free: Sequence[str] = (),
    parts: str | Path | None = None,
    progress: Progress = quiet,
) -> Identification:
    """Identify curves and numbers of a machine from a log of its work, inside its known equations.

    For each circuit of valves in series: inlet, bypass and outlet conductances over spool travel, monotone, on knots that are added where blocks of
    time held out ask for them; flow of the pump, and its relief setting and torque limit where rows show them. For each function with voltage and
    spool: gain, time constant and dead time of its pilot, and hysteresis and flow force of the spool where they are free. Masses and friction that
    are marked: by regression from pressures and positions, and from joints at rest whether friction holds them. What is free and has not the sensors for these: through simulation, from voltages and
    positions of all functions and whatever else there is.
    Numbers that the sensors do not determine keep their value. Beyond the travel that the log has, curves go on in the shape they had,
    scaled to meet, and a bypass with its slope until it shuts where it did.

    Parameters
    ----------
    log : Table, str, Path or sequence of them
        Or its file, an imported log in SI: ``time``, and of each function what there is of ``NAME.spool``, ``NAME.p_a``, ``NAME.p_b``,
        ``NAME.q_in``, ``NAME.q_out``, ``NAME.voltage``, ``NAME.angle`` (``NAME.position`` of a joint that slides). Of a log that declares missing
        values, each pilot, circuit and way takes the rows that have what it needs. A circuit needs spool and both
        pressures of all its functions, and flows or joints; without flow sensors, flows are balanced over windows by what joints
        displace and pressures compress.
    machine : LayoutMachine, str or Path
        To begin from, or its name or file.
    free : sequence of str
        Patterns of paths that may change, such as ``functions.*.valve.*``, besides what the file marks with ``free = true``. If nothing is
        marked either, curves, pumps, pilots and effects of spools that the file declares may; masses and friction only where a log tells nothing
        else. Whether dry friction holds joints is found only by a pattern that ends so, ``functions.*.friction.sticks``.
    parts : str or Path, optional
        Folder in which finished circuits, and how far simulation has come, are kept, and found again by the next call with the same log and machine.
    progress : Progress, optional

    Returns
    -------
    Identification

    Raises
    ------
    InputError
        A log that determines nothing, and why; columns in other units; times that do not rise; a pattern that fits nothing.
    """
    before = machine if isinstance(machine, LayoutMachine) else load_machine(machine)
    data = {} if isinstance(machine, LayoutMachine) else read_toml(machine_path(machine))
    if "functions" not in data:  # no file, or one of the older form, which has other places for the same numbers
        data = machine_data(before)
    may = freedom(before, data, free)
    table, source = table_of(
        log,
        ["time"],
        ["segment", *(f"{name}.voltage" for name in before.names), *run_sensors(before)],
        partial=True,
    )
    dead = [name for name in table.names if not table.known([name]).any()]
    table = _without(table, dead)
    check_functions(before, table)
    check_units(table)
    check_plausible(before, table)
    segment = _segments(table, source)
    check_one_raster(table)
    table, stuck = without_stuck(before, table)
    raster = raster_within(table["time"], segment)
    doubts = channel_doubts(before, table)
    table = _without(table, {column for doubt in doubts for column in doubt.columns})
    against = against_spools(before, table, segment)
    table = _without(table, [f"{name}.voltage" for name in against])
    runs_well = not lacking_for_runs(before, table)
    besides = any(map(is_effect, may.spreads)) or any(map(any, map(declared_effects, before.functions)))
    turns = _TURNS if besides else 1
    of_circuits, simulated = _CIRCUIT_STEPS * turns * len(before.circuits), _RUN_STEPS if runs_well else 0
    steps = len(before.functions) + of_circuits + 1 + simulated
    with one_blas_thread():  # matrices are narrow: threads would cost more than they do
        signals: dict[str, Signals] = {}
        for number, f in enumerate(before.functions):
            progress(f"{f.name}: sensors and pilot", number, steps)
            signals[f.name] = read_function(
                before, f, table, segment, raster, may.has(f"functions.{f.name}.pilot.time_constant")
            )
        finished = Finished(parts, _digest(table, data, may))
        at, pilots = len(before.functions), find_pilots(SoFar(before, may, source), signals, raster)
        shown = {c.name for c in before.circuits} - set(refused_circuits(before, signals, may, len(segment)))
        of_turn = _CIRCUIT_STEPS * len(shown)
        of_circuits = turns * of_turn
        looked = [name for name, s in signals.items() if s.pilot is not None]
        if not entries_left(SoFar(before, may, source), _taken(before, may, looked, pilots, shown, None)):
            simulated = 0
        steps = at + of_circuits + 1 + simulated
        so_far, pilots, circuits, spools = _in_turns(
            before, may, source, table, segment, raster, signals, finished, turns,
            lambda turn, place, share, what: progress(
                what, at + turn * of_turn + min(int(_CIRCUIT_STEPS * (place + share)), of_turn), steps
            ),
        )  # fmt: skip
        so_far.kept += [f"{name}: has no value in the whole log, and is not used" for name in dead]
        so_far.kept += stuck
        so_far.kept += [f"not used: {', '.join(doubt.columns)}; {doubt.text}" for doubt in doubts]
        so_far.kept += [
            f"{name}.voltage and {name}.spool move against each other, so that one of them has the wrong sign: the voltage is not used; turn the "
            "wrong one where the log is imported"
            for name in against
        ]
        at += of_circuits
        if runs_well and not simulated and shown != set(circuits):  # a circuit whose rows say too little is left over
            simulated = _RUN_STEPS
            steps += simulated
        progress("masses and friction", at, steps)
        mechanics = find_mechanics(so_far, table, unasked=not so_far.changes and not runs_well)
        find_holding(so_far, table)
        taken = _taken(before, may, spools, pilots, circuits, mechanics)
        runs = find_left(
            so_far,
            table,
            taken,
            finished,
            lambda done, of: progress("simulation", at + 1 + done * simulated // of, steps),
        )
    lacks = [
        f"{what}: {'not by regression' if runs and not what.startswith(taken) else 'kept'}; {why}"
        for what, why in so_far.lacks.items()
    ]
    now, then = ([f.effects for f in machine.functions] for machine in (so_far.machine, before))
    if not so_far.changes and now == then:
        raise InputError("; ".join([f"{source} determines nothing of this machine", *lacks, *so_far.kept]))
    finished.forget()
    progress("identified", steps, steps)
    return Identification(
        so_far.found(), before, so_far.changes, circuits, pilots, mechanics, runs, [*lacks, *so_far.kept], so_far.remarks, may, table,
        source, data,
    )  # fmt: skip


def _in_turns(
    before: LayoutMachine, may: Freedom, source: str, table: Table, segment: np.ndarray, raster: float, signals: dict[str, Signals],
    finished: Finished, turns: int, tell: Callable[[int, int, float, str], object],
) -> tuple[SoFar, dict[str, PilotFit], dict[str, CircuitFound], dict[str, SpoolFound]]:  # fmt: skip
    """Pilots, circuits and what spools do besides, each turn by what the one before knew of spools; fewer turns where they do nothing.

    Parameters
    ----------
    before, may, source, table, segment, raster, finished
        As `identify` has them.
    signals : dict from function to Signals
        As sensors and pilots alone have them.
    turns : int
        At most; effects of spools are looked at after each.
    tell : callable
        Told the turn, the place of a circuit, about which share of it is done, and what is being done.
    """
    for turn in range(turns):
        so_far = SoFar(before, may, f"identified from {source}")
        circuits = find_circuits(so_far, signals, table["time"], segment, raster, finished, partial(tell, turn), turn)
        spools, circuits = look_at_spools(so_far, signals, circuits, table, segment)
        moved = smoothed_again(before, may, signals, spools, table, segment)
        if not moved:
            break
        signals = signals | moved
    take_curves(so_far, circuits)
    pilots = find_pilots(so_far, signals, raster)
    take_effects(so_far, signals, spools)
    return so_far, pilots, circuits, spools


def _taken(
    machine: LayoutMachine,
    may: Freedom,
    spools: Container[str],
    pilots: Container[str],
    circuits: Container[str],
    mechanics: MechanicsFit | None,
) -> tuple[str, ...]:
    """Beginnings of paths that need no simulation: their numbers were found, or looked for with better means."""
    found = [f"functions.{f.name}.pilot." for f in machine.functions if f.name in pilots]
    found += [f"functions.{f.name}.{HOLDS}" for f in machine.functions]
    # without its sensors an effect is for simulation only where a file says how far it may be off
    found += [
        p for p, spread in may.spreads.items() if is_effect(p) and (p.split(".")[1] in spools or np.isnan(spread))
    ]
    for circuit in machine.circuits:
        if circuit.name in circuits:
            found += [f"{circuit.pump_path}.", *(f"functions.{name}.valve." for name in circuit.functions)]
    return (*found, *(e.path for e in mechanics.estimates.numbers)) if mechanics else tuple(found)


def _without(table: Table, names: Collection[str]) -> Table:
    """A table without some columns."""
    some = Table({name: v for name, v in table.columns.items() if name not in names}, table.units, table.info)
    return some.partial() if MISSING in table else some


def _segments(table: Table, source: str) -> np.ndarray:
    """Numbers of stretches of rows without a gap, (n_row,) of int, of a log that is long enough and whose times rise."""
    time = table["time"]
    if len(time) < LEAST_ROWS:
        raise InputError(f"{source} determines nothing of this machine: it has {len(time)} rows; {LEAST_ROWS} at least")
    check_rises(time)
    return raster_segments(table)


def _digest(table: Table, data: dict[str, Any], may: Freedom) -> str:
    digest = hashlib.sha256(repr((sorted(may.spreads.items()), data)).encode())
    for name in table.names:
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(table.columns[name]).tobytes())
    return digest.hexdigest()
