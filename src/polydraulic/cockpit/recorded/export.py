"""A recorded drive as what other commands take: a scenario for `simulate`, and a log for `import` and `identify`."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.cockpit.own_networks import with_networks
from polydraulic.cockpit.recorded.drives import Drive, read_drive
from polydraulic.cockpit.recorded.player import Player
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet
from polydraulic.simulation.stepping.simulator import Simulator
from polydraulic.tables import Table, table_ending, table_writer, write_table

_PIECE = 2000  # steps between two words of progress


class DriveLevers(NamedTuple):
    """What was done in a drive from some step on.

    Attributes
    ----------
    volts : (n_step, n_function) array, V
    payload : list of (step, kg)
        From which step on.
    """

    volts: np.ndarray
    payload: list[tuple[int, float]]


def export_drive(
    drive: Drive | str | Path,
    *,
    scenario: str | Path | None = None,
    log: str | Path | None = None,
    raster: float = 0.01,
    models: Sequence[Path] = (),
    progress: Progress = quiet,
) -> None:
    """Write a drive as a scenario, as a log, or both.

    Parameters
    ----------
    drive : Drive, or path of a recorded one
    scenario : str or Path, optional
        ``.toml``; the levers are written beside it as ``.csv``. `simulate` gives the bits of the drive from its last reset on.
    log : str or Path, optional
        ``.csv`` or ``.parquet``: time, voltages of the levers and all that the machine did, SI.
    raster : float, s
        Of the log, a whole number of steps.
    models : sequence of Path
        Files of the networks with which the drive was recorded, if these did not come with the package.
    progress : Progress, optional

    Raises
    ------
    InputError
        A drive that cannot be replayed bit for bit; one that is no scenario, since its machine was another one, or began elsewhere.
    """
    found = drive if isinstance(drive, Drive) else read_drive(drive)
    if scenario is None and log is None:
        raise InputError("nothing to write: give a scenario (.toml), a log (.csv or .parquet), or both")
    if scenario is not None and Path(scenario).suffix != ".toml":
        raise InputError(f"{scenario}: a scenario ends in .toml")
    if log is not None:
        table_ending(log)
    if scenario is not None:
        _write_scenario(found, Path(scenario))
    if log is not None:
        _write_log(found, Path(log), raster, progress, models)


def simulator_of(drive: Drive, models: Sequence[Path] = ()) -> Simulator:
    """A simulator built as the one that was recorded, with networks from the same files.

    Raises
    ------
    InputError
    """
    machine = as_machine(drive.head["machine"])
    flow, _ = with_networks(machine, drive.head["flow"], None, models)
    return Simulator(machine, flow, dt=drive.head["dt"], load={"payload": 0.0})


def levers_from_start(drive: Drive) -> DriveLevers:
    """What was done since the machine last began anew.

    Raises
    ------
    InputError
        A drive in which it did not, or of which numbers of the machine were changed.
    """
    resets = [k for k, stamp in enumerate(drive.stamps) if stamp.get("reset")]
    first = resets[-1] if resets else 0
    if drive.head["values"] or any("change" in stamp for stamp in drive.stamps):
        raise InputError(
            f"the drive {drive.name} has faults, which are recorded as numbers and not by name: export a log"
        )
    if not resets:
        raise InputError(
            f"the drive {drive.name} does not begin at the machine's start, as scenarios do: begin to record, then reset; or export a log"
        )
    begin = int(drive.stamps[first]["step"])
    volts, payload = np.zeros((drive.end - begin, len(drive.head["functions"]))), [(0, 0.0)]
    volts[:] = next((stamp["levers"] for stamp in reversed(drive.stamps[:first]) if "levers" in stamp), 0.0)
    for stamp in drive.stamps[first:]:
        step = stamp["step"] - begin
        if "levers" in stamp:
            volts[step:] = stamp["levers"]
        if "payload" in stamp:
            payload = [pair for pair in payload if pair[0] < step] + [(step, float(stamp["payload"]))]
    if not len(volts):
        raise InputError(f"the drive {drive.name} ends where it begins anew; there is nothing to export")
    return DriveLevers(volts, payload)


def _write_scenario(drive: Drive, path: Path) -> None:
    head, levers = drive.head, levers_from_start(drive)
    names, dt, n = head["functions"], head["dt"], len(levers.volts)
    beside = path.with_suffix(".csv")
    last = levers.volts[-1:]  # held to the end
    rows = np.vstack([levers.volts, last])
    columns = {"time": dt * np.arange(n + 1), **{name: rows[:, k] for k, name in enumerate(names)}}
    write_table(Table(columns, {"time": "s", **dict.fromkeys(names, "V")}), beside)
    source = json.dumps(f"recorded drive {drive.name}")
    machine = Path(head["machine"]).resolve() if head["machine"].endswith(".toml") else head["machine"]

    def quantity(value: object, unit: str) -> str:
        return f'{{ value = {json.dumps(value)}, unit = "{unit}", source = {source} }}'

    text = [
        f"title = {json.dumps(f'Drive {drive.name}')}",
        f"machine = {json.dumps(str(machine))}",
        f"source = {source}",
        f"duration = {quantity(n * dt, 's')}",
        "",
        "[payload]",
        f"time = {quantity([step * dt for step, _ in levers.payload], 's')}",
        f"mass = {quantity([mass for _, mass in levers.payload], 'kg')}",
    ]
    for name in names:
        table = {"kind": "table", "file": beside.name, "time_column": "time", "voltage_column": name}
        text += ["", f"[voltage.{name}]", *(f"{key} = {json.dumps(value)}" for key, value in table.items())]
    write_text(path, "\n".join(text) + "\n")


def _write_log(drive: Drive, path: Path, raster: float, progress: Progress, models: Sequence[Path]) -> None:
    simulator = simulator_of(drive, models)
    every = round(raster / simulator.dt)
    if every < 1 or abs(every * simulator.dt - raster) > 1e-9:
        raise InputError(f"raster = {raster:g} s: must be a whole number of steps of {simulator.dt:g} s")
    names = list(simulator.place)
    with table_writer(path, {"time": "s", **{name: simulator.units[name] for name in names}}) as write:
        for block in _played(drive, simulator, every, progress):
            write(list(block.T))


def _played(drive: Drive, simulator: Simulator, every: int, progress: Progress) -> Iterator[np.ndarray]:
    """Rows of a drive, in blocks: time since its beginning, then columns; levers are those of the step that follows."""
    player, take = Player(drive, simulator, simulator.machine), list(simulator.place.values())
    names = list(simulator.place)
    levers = [1 + names.index(f"{name}.voltage") for name in simulator.names]
    rows: list[np.ndarray] = []
    whole = max(-(-drive.end // _PIECE), 1)
    while not player.ended:
        row = np.array([player.step * simulator.dt, *simulator.values[take]])
        player.advance(every)
        row[levers] = simulator.values[take][np.array(levers) - 1]
        rows.append(row)
        if len(rows) == _PIECE or player.ended:
            progress("drive once more", player.step // _PIECE, whole)
            yield np.array(rows)
            rows = []
