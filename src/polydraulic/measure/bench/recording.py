"""A virtual test bench: simulated runs as sensors read them, written as a log, so that a path from logs can meet a known truth."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.files import replacing
from polydraulic.measure.bench.sensors import Bench, Reading
from polydraulic.measure.log_units import need
from polydraulic.parameters.deviations import Fault, ScheduledFault
from polydraulic.parameters.fault_catalogue import as_list, timed_faults
from polydraulic.parameters.faults import unread_faults
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.scenario import Scenario, as_scenario
from polydraulic.progress import Progress, quiet
from polydraulic.simulation.runs import simulate
from polydraulic.tables import Table

ENDINGS = (".csv", ".mf4", ".parquet")
Samples = dict[str, tuple[np.ndarray, np.ndarray]]  # by sensor: times, values


def record(
    machine: LayoutMachine | str | Path,
    scenarios: Sequence[Scenario | str | Path],
    bench: Bench,
    out: str | Path,
    *,
    dt: float = 5e-3,
    faults: Sequence[str | Fault | ScheduledFault] = (),
    progress: Progress = quiet,
) -> int:
    """Simulate scenarios with the exact flow and write what sensors read of them.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    scenarios : sequence of Scenario, or names or paths of some
        One after the other, with a pause in which nothing is recorded.
    bench : Bench
        From `load_sensors`. The same seed gives the same log.
    out : str or Path
        ``.csv`` and ``.parquet``: a row at each time at which a sensor reads, empty where the others do not; ``.mf4``: a group for
        each raster.
    dt : float, s
        Time step of the simulation.
    faults : sequence of str, Fault or ScheduledFault
        As for `simulate`, besides those of the scenarios, with times of the log: the machine's act in the simulation, those of sensors on what
        these measure, before noise.
    progress : Progress, optional
        Told the name of each scenario as it begins.

    Returns
    -------
    int
        Number of samples.

    Raises
    ------
    InputError
        Another ending, no scenario, a sensor of a column that the runs do not have, a fault of a sensor that there is not.
    """
    ending = log_ending(out)
    if not scenarios:
        raise InputError("there is no scenario to record; give at least one")
    machine = as_machine(machine)
    runs = [as_scenario(scenario, machine.names) for scenario in scenarios]
    rngs = [np.random.default_rng([bench.seed, n]) for n in range(len(bench.sensors))]
    readings = [Reading(sensor, rng) for sensor, rng in zip(bench.sensors, rngs, strict=True)]
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {sensor.name: [] for sensor in bench.sensors}
    for scenario in runs:  # before any of them takes long
        beginning = simulate(machine, "exact", scenario, dt=dt, t_end=min(dt, scenario.duration))
        for reading in readings:
            reading.check(beginning)
    timed = timed_faults(machine, as_list(faults))
    own = [timed_faults(machine, scenario.faults) for scenario in runs]
    columns = [sensor.column for sensor in bench.sensors]
    unread = unread_faults((one for many in (timed, *own) for one in many), columns)
    if unread:
        raise InputError(
            f"a fault is of {unread[0]!r}, which no sensor reads; there are sensors of {', '.join(columns)}"
        )
    end = sum(scenario.duration for scenario in runs) + bench.pause * (len(runs) - 1)
    late = [one for one in timed if one.begin >= end]
    if late:
        raise InputError(
            f"fault {late[0].fault.name!r} begins at {late[0].begin:g} s, and the log ends at {end:g} s: let it begin sooner, or record longer"
        )
    begin = 0.0
    for number, scenario in enumerate(runs):
        progress(scenario.name, number, len(runs))
        of_log = [one.after(begin) for one in timed]
        run = simulate(machine, "exact", scenario, dt=dt, faults=of_log)
        for reading in readings:
            time, value = reading.of(run, [*own[number], *of_log])
            parts[reading.sensor.name].append((begin + time, value))
        begin += float(run["time"][-1]) + bench.pause
    samples = {
        name: (np.concatenate([t for t, _ in of]), np.concatenate([v for _, v in of])) for name, of in parts.items()
    }
    units = {sensor.name: sensor.unit for sensor in bench.sensors}
    writer = {".csv": _write_csv, ".parquet": _write_parquet, ".mf4": _write_mdf}[ending]
    with replacing(out) as temporary:
        writer(samples, units, temporary)
    return int(sum(np.isfinite(value).sum() for _, value in samples.values()))


def log_ending(path: str | Path) -> str:
    """Ending of a log that can be written, or an InputError."""
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        raise InputError(f"{path}: a recorded log ends in one of {list(ENDINGS)}, not in {ending!r}")
    if ending == ".mf4":
        need("asammdf")
    return ending


def _rows(samples: Samples) -> Table:
    """All sensors on the times at which any of them reads; NaN where one does not."""
    every = np.concatenate([time for time, _ in samples.values()])
    time = np.unique(np.round(every, 9))  # rasters meet but for rounding
    columns = {"time": time}
    for name, (at, value) in samples.items():
        columns[name] = np.full(len(time), np.nan)
        columns[name][np.searchsorted(time, np.round(at, 9))] = value
    return Table(columns, {})


def _write_csv(samples: Samples, units: dict[str, str], path: Path) -> None:
    table = _rows(samples)
    heads = ["time [s]", *(f"{name} [{unit}]" if unit else name for name, unit in units.items())]
    rows = table.matrix(table.names)
    with path.open("w", encoding="utf-8") as file:
        file.write(",".join(heads) + "\n")
        for row in rows:
            file.write(",".join("" if v != v else f"{v:.10g}" for v in row.tolist()) + "\n")


def _write_parquet(samples: Samples, units: dict[str, str], path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = _rows(samples)
    fields = [pa.field(name, pa.float64(), metadata={"unit": {"time": "s", **units}[name]}) for name in table.names]
    columns = [pa.array(table[name], from_pandas=True) for name in table.names]
    pq.write_table(pa.table(columns, schema=pa.schema(fields)), path)


def _write_mdf(samples: Samples, units: dict[str, str], path: Path) -> None:
    library = need("asammdf")
    groups: dict[bytes, list[str]] = {}
    for name, (time, _) in samples.items():
        groups.setdefault(time.tobytes(), []).append(name)
    with library.MDF(version="4.10") as file:
        # what is simulated has no date, and the same seed gives the same log
        file.start_time = datetime(1970, 1, 1, tzinfo=UTC)
        for names in groups.values():
            signals = []
            for name in names:
                time, value = samples[name]
                missing = np.isnan(value)
                options = {"invalidation_bits": missing} if missing.any() else {}
                signals.append(library.Signal(np.where(missing, 0.0, value), time, units[name], name, **options))
            file.append(signals, common_timebase=True)
        file.save(path, overwrite=True)
