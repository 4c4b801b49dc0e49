"""Faults watched for in logs of simulated machines: when they are found, how they are named, and what healthy work is taken for.

The machine that is watched was identified from a noisy log of its own healthy work, and what is to be expected of it was learnt from the
same log. Each fault begins in the log of another operator. It has an occasion to show in a second in which its smallest size would move
what is read by a standard deviation at least; a drift counts from half of that size on.
"""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.special import gammaincinv

from polydraulic.files import write_text
from polydraulic.identification.plausible import UNITS
from polydraulic.identification.watching.watch_log import learnt_from, log_blocks, watched_columns
from polydraulic.measure.bench.sensors import Reading, example_sensors, load_sensors
from polydraulic.parameters.fault_catalogue import FaultKind, fault_catalogue, timed_faults
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import random_operator
from polydraulic.simulation.runs import simulate
from polydraulic.tables import Table
from polydraulic.watch.block import scores_of
from polydraulic.watch.blocks import starts_of
from polydraulic.watch.drift import BIAS, DRIFT
from polydraulic.watch.expected import Expected, whitened
from polydraulic.watch.kernels.stays import RESTS
from polydraulic.watch.learning import FALSE_ALARMS
from polydraulic.watch.naming import FaultNetworks
from polydraulic.watch.sequential import threshold_for
from polydraulic.watch.watch import FREEZE, FaultWatch
from polydraulic.watch.watched import Watched, plan_of, tests_of, watched

RASTER = 0.02  # s, of all sensors
BEGINS, LASTS = 30.0, 120.0  # s into a log after which a fault begins, and for which it lasts
DRIFTS = 450.0  # s for which a drift lasts; it takes ten minutes to its size
WITHIN = 60  # s in which a fault could show, after which it counts as late
SURE = 0.95  # with which a rate of false alarms is bounded
_LIMIT = 1.1  # V: full travel of all spools
_STEP, _SHORT_STEP = 5e-3, 2.5e-3  # s; flow forces of worn edges want the shorter one
_UNUSUAL_LASTS = 90.0  # s
_PUMP = ".p_pump"
_PUMP_SENSOR = """
[[sensor]]
column = "{}"
unit = "bar"
raster = "20 ms"
noise = 1.0
dropout = 0.001
"""  # as those of pressures at ports


class WatchedCase(NamedTuple):
    """A true machine, what is watched of the one identified from it, and what is to be expected of that."""

    true: LayoutMachine
    of: Watched
    expected: Expected

    @property
    def pumps(self) -> list[str]:
        """Circuits the pressure of whose pump is read."""
        return [column.removesuffix(_PUMP) for column in self.of.columns if column.endswith(_PUMP)]


class WatchedFault(NamedTuple):
    """What became of a fault.

    Attributes
    ----------
    fault, title : str
    named : str
        The first suspect of the first alarm since the fault began; empty if there was none.
    could_show : int, s
        Of the whole log.
    delay : int, s
        In which it could show, until the alarm.
    clock : float, s
        Until the alarm, by the clock; both of no meaning where there was none.
    judged_before, alarms_before : int
        Seconds that were judged until it began, and alarms in them, which are false.
    hidden : bool
        Whether it would have had an occasion to show if only sensors were noisy, and the identified machine were the true one.
    opinion : str
        Kind that networks took it for, where there were some.
    """

    fault: str
    title: str
    named: str
    could_show: int
    delay: int
    clock: float
    judged_before: int
    alarms_before: int
    hidden: bool = False
    opinion: str = ""

    @property
    def outcome(self) -> str:
        """``"in time"``, ``"late"``, ``"missed"``, or of one that could not show for long enough ``"hidden"`` or ``"no occasion"``."""
        if self.named:
            return "in time" if self.delay <= WITHIN else "late"
        if self.could_show >= WITHIN:
            return "missed"
        return "hidden" if self.hidden else "no occasion"

    @property
    def could(self) -> bool:
        """Whether it could show for long enough, or did."""
        return self.outcome not in ("hidden", "no occasion")


class Healthy(NamedTuple):
    """Seconds of healthy work that were judged, and what its false alarms were named."""

    seconds: int
    named: list[str]


def fault_kind(fault: str) -> str:
    """What a fault is, whatever it is of: ``leak_across`` of ``boom.leak_across``."""
    return fault.rpartition(".")[2]


def most_per_hour(alarms: int, seconds: float) -> float:
    """Rate that so few alarms of a Poisson process leave possible, with a certainty of `SURE` (one-sided, exact); per hour."""
    return float(gammaincinv(alarms + 1, SURE)) * 3600.0 / seconds


def work_log(
    machine: LayoutMachine, seed: int, seconds: float, faults: Sequence[str] = (), pumps: Sequence[str] = ()
) -> Table:
    """What sensors read of a random operator's work, with noise as `example_sensors` has it: rows in which all of them are known.

    Pressures of pumps are read of circuits that are asked for.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sensors.toml"
        more = (_PUMP_SENSOR.format(f"{circuit}{_PUMP}") for circuit in pumps)
        write_text(path, "".join([example_sensors(machine=machine), *more]))
        bench = load_sensors(path)
    timed = timed_faults(machine, faults)
    dt = _SHORT_STEP if machine.functions[0].effects.declared else _STEP
    work = random_operator(seed, seconds, limit=_LIMIT, functions=machine.names)
    run = simulate(machine, "exact", work, dt=dt, every=round(RASTER / dt), faults=timed)
    columns, time = {}, np.empty(0)
    for number, sensor in enumerate(bench.sensors):
        reading = Reading(sensor, np.random.default_rng([seed, number]))
        time, value = reading.of(run, timed)
        columns[sensor.column] = reading.conversion.to_si(value)
    known = np.flatnonzero(np.all([np.isfinite(v) for v in columns.values()], axis=0))
    segment = np.concatenate([[0], np.cumsum(np.diff(known) > 1)]).astype(float)
    rows = {"time": time[known], "segment": segment, **{name: v[known] for name, v in columns.items()}}
    return Table(rows, {"time": "s", "segment": "", **{name: UNITS[name.rpartition(".")[2]] for name in columns}})


def case_of_log(
    true: LayoutMachine, identified: LayoutMachine, log: Table, sensors: Sequence[str] | None = None
) -> WatchedCase:
    """What there is to watch of an identified machine by these sensors (all if not given), and what to expect by its healthy log."""
    of = watched(identified, watched_columns(identified, log, "log", sensors), RASTER)
    return WatchedCase(true, of, learnt_from(of, log, np.ones(len(log), dtype=bool), FALSE_ALARMS))


def faults_watched(case: WatchedCase) -> list[FaultKind]:
    """Faults of the catalogue that are watched for."""
    names = {d.name for d in case.of.directions} | {f"{c}{FREEZE}" for c in case.of.columns}
    return [kind for kind in fault_catalogue(case.true) if kind.name in names]


def drifts_watched(case: WatchedCase) -> list[FaultKind]:
    """Drifts of sensors that are watched for: of those that a bias is watched for of."""
    names = {d.name for d in case.of.directions}
    return [kind for kind in fault_catalogue(case.true) if kind.name.endswith(DRIFT) and _found_as(kind.name) in names]


def _found_as(fault: str) -> str:
    """Direction along which a fault is found: of a drift that of the bias that it becomes."""
    return fault.removesuffix(DRIFT) + BIAS if fault.endswith(DRIFT) else fault


def schedule(kind: FaultKind) -> tuple[str, str]:
    """A fault in its smallest size from `BEGINS` on, as logs take it; and its title."""
    smallest = min(map(abs, kind.sizes)) if kind.sizes else None
    size = "" if smallest is None else f" {kind.shown(smallest)}"
    return f"{kind.name}{size} from {BEGINS:g} s", kind.title(smallest)


def watch_fault(case: WatchedCase, kind: FaultKind, seed: int, networks: FaultNetworks | None = None) -> WatchedFault:
    """A fault in its smallest size, watched for in the log of an operator; named by networks as well, where there are some."""
    text, title = schedule(kind)
    readings, begins = _blocks(
        case, work_log(case.true, seed, BEGINS + (DRIFTS if kind.growth else LASTS), [text], case.pumps)
    )
    watch = FaultWatch(case.of, case.expected, networks=networks)
    watch.judge(readings, begins)
    share = _present(kind, begins - BEGINS)
    shown = np.cumsum(_shows(case, readings, kind.name, share))
    before = int(np.sum(begins < BEGINS))
    early = sum(alarm.seen <= BEGINS for alarm in watch.alarms)
    alarm = next((alarm for alarm in watch.alarms if alarm.seen > BEGINS), None)
    if alarm is None:
        hidden = int(_shows(case, readings, kind.name, share, exact=True).sum()) >= WITHIN
        return WatchedFault(kind.name, title, "", int(shown[-1]), 0, 0.0, before, early, hidden)
    named = alarm.suspects[0].name if alarm.suspects else "unknown"
    at = min(int(np.searchsorted(begins, alarm.seen)) - 1, len(shown) - 1)
    opinion = alarm.opinion.kind if alarm.opinion else ""
    return WatchedFault(
        kind.name, title, named, int(shown[-1]), int(shown[at]), alarm.seen - BEGINS, before, early, False, opinion
    )  # fmt: skip


def watch_healthy(case: WatchedCase, machine: LayoutMachine, seed: int, seconds: float) -> Healthy:
    """Work without a fault of `machine` (the true one, or that in unusual work), watched."""
    readings, begins = _blocks(case, work_log(machine, seed, seconds, pumps=case.pumps))
    watch = FaultWatch(case.of, case.expected)
    watch.judge(readings, begins)
    return Healthy(len(begins), [a.suspects[0].name if a.suspects else "unknown" for a in watch.alarms])


def watch_unusual(case: WatchedCase, seed: int) -> list[tuple[str, str]]:
    """Cold oil and payloads of a minute and a half each, in words; and what they are named."""
    true = case.true
    thick = {f"functions.{f.name}.friction.viscous": 2.0 * f.friction.viscous for f in true.functions}
    mass = next(k for k in fault_catalogue(true) if k.name == "tip.payload_unknown").sizes[0]
    machines = {
        "oil cold, viscous friction doubled": true.with_values(thick),
        f"payload of {mass:.0f} kg": with_payload(true, mass),
        f"payload of {4.0 * mass:.0f} kg": with_payload(true, 4.0 * mass),
    }
    named = {what: watch_healthy(case, machine, seed, _UNUSUAL_LASTS).named for what, machine in machines.items()}
    return [(what, "; ".join(dict.fromkeys(names)) or "no alarm") for what, names in named.items()]


def evidence_over_time(case: WatchedCase, kind: FaultKind, seed: int) -> Table:
    """Evidence of a fault, as a share of what makes an alarm, over the same work with it and without, and the most of all faults.

    Columns ``time``, ``faulty.own``, ``faulty.most``, ``healthy.own``, ``healthy.most``.
    """
    own = [d.name == kind.name for d in case.of.directions]
    columns: dict[str, np.ndarray] = {}
    for name, faults in (("faulty", [schedule(kind)[0]]), ("healthy", [])):
        readings, begins = _blocks(case, work_log(case.true, seed, BEGINS + LASTS, faults, case.pumps))
        watch, seen = FaultWatch(case.of, case.expected), list[np.ndarray]()
        watch.judge(readings, begins, _keep(watch, seen))
        columns["time"] = begins + case.of.shape.seconds
        columns[f"{name}.own"] = np.array(seen)[:, own].max(axis=1)
        columns[f"{name}.most"] = np.array(seen).max(axis=1)
    return Table(columns, {"time": "s"})


def _keep(watch: FaultWatch, seen: list[np.ndarray]) -> Callable[[], None]:
    return lambda: seen.append(watch.shares)


def _blocks(case: WatchedCase, log: Table) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Readings of the blocks of a log, and when each begins."""
    starts = starts_of(log["time"], log["segment"], case.of.shape)
    return log_blocks(case.of, log, starts), log["time"][starts + case.of.shape.before]


def _present(kind: FaultKind, since: np.ndarray) -> np.ndarray:
    """Share of its smallest size that a fault has so many seconds after its beginning; below half of that it counts for none."""
    share = since / kind.growth if kind.growth else 1.0 * (since >= 0.0)
    return np.where(share >= 0.5, np.minimum(share, 1.0), 0.0)


def _shows(
    case: WatchedCase, readings: dict[str, np.ndarray], fault: str, share: np.ndarray, *, exact: bool = False
) -> np.ndarray:
    """In which blocks a fault of a share of its smallest size has an occasion to show, (n_block,) of bool; `exact`: of a machine without errors."""
    of, expected = case.of, case.expected
    names = [d.name for d in of.directions]
    scales = ((0.0, 1.0),) * len(of.channels) if exact else expected.scales
    scores, states = scores_of(plan_of(of, expected.noise), readings, scales)
    if (direction := _found_as(fault)) in names:
        place = names.index(direction)
        if exact:
            told = scores.information[:, place, place]
        else:
            known = whitened(scores, expected.offset, expected.jitter).information[:, place]
            # if what strays leaves too little even of a minute in which it shows, no second is an occasion
            most = 0.5 / (1.0 / WITHIN + expected.slow[place])
            told = (
                known
                / expected.together[place]
                * (most >= threshold_for(FALSE_ALARMS, tests_of(of.directions), of.shape.seconds))
            )
        return np.asarray(told * share**2 >= 1.0)
    column = fault.removesuffix(FREEZE)  # of a sensor that stays: wherever its function works
    return np.asarray((states[:, of.columns.index(column)] != RESTS) & (share > 0.0))
