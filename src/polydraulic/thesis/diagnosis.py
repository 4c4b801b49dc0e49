"""The diagnosis of the report: two identified machines, a fault of each kind, healthy and unusual work; kept by the lab."""

from functools import cached_property
from typing import Any

import numpy as np

from polydraulic.identification.equations.identify import identify
from polydraulic.parameters.fault_catalogue import FaultKind
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import load_machine
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.diagnosis_study import (
    Healthy,
    WatchedCase,
    WatchedFault,
    case_of_log,
    drifts_watched,
    evidence_over_time,
    fault_kind,
    faults_watched,
    watch_fault,
    watch_healthy,
    watch_unusual,
    work_log,
)
from polydraulic.thesis.rough_machine import rough_machine

LEARNT = 600.0  # s, of the log that a machine is identified from; memory grows with it
HEALTHY_LOGS, HEALTHY_LASTS = 4, 600.0  # of each machine; s
# Operators of the log to learn from, of faults, of healthy and of unusual work; nothing was chosen by them.
LEARNT_SEED, FAULT_SEED, HEALTHY_SEED, UNUSUAL_SEED = 11000, 11100, 11500, 11900
DRAWN = "leak_across"  # kind of the fault whose evidence is drawn


class Diagnosis:
    """What watching one machine finds; each part is computed when it is asked for.

    Parameters
    ----------
    lab : Lab
    machine : LayoutMachine
    name : str
        Under which it is kept.
    """

    def __init__(self, lab: Lab, machine: LayoutMachine, name: str) -> None:
        self.lab, self.machine, self.name = lab, machine, name

    @cached_property
    def case(self) -> WatchedCase:
        """The machine identified from a log of its healthy work."""
        self.lab.say(f"identify {self.name} from {LEARNT / 60.0:g} min of its work")
        log = work_log(self.machine, LEARNT_SEED, LEARNT)
        start = rough_machine(self.machine, np.random.default_rng(LEARNT_SEED))
        return case_of_log(self.machine, identify(log, start).machine, log)

    @cached_property
    def found(self) -> list[WatchedFault]:
        """A fault of each kind in its smallest size."""

        def made() -> list[Any]:
            faults = one_of_each_kind([*faults_watched(self.case), *drifts_watched(self.case)])
            rows = []
            for number, kind in enumerate(faults):
                self.lab.say(f"watch {self.name}, fault {number + 1} of {len(faults)}: {kind.name}")
                rows.append(watch_fault(self.case, kind, FAULT_SEED + number))
            return [list(row) for row in rows]

        return [WatchedFault(*row) for row in self.lab.computed.data(f"diagnosis {self.name} faults", made)]

    @cached_property
    def healthy(self) -> list[Healthy]:
        """Logs of healthy work."""

        def made() -> list[Any]:
            rows = []
            for number in range(HEALTHY_LOGS):
                self.lab.say(f"watch {self.name}, healthy log {number + 1} of {HEALTHY_LOGS}")
                rows.append(watch_healthy(self.case, self.machine, HEALTHY_SEED + number, HEALTHY_LASTS))
            return [list(row) for row in rows]

        return [Healthy(*row) for row in self.lab.computed.data(f"diagnosis {self.name} healthy", made)]

    @cached_property
    def unusual(self) -> list[tuple[str, str]]:
        """Unusual work, and what it is named."""

        def made() -> list[Any]:
            self.lab.say(f"watch {self.name}, unusual work")
            return [list(row) for row in watch_unusual(self.case, UNUSUAL_SEED)]

        return [(work, named) for work, named in self.lab.computed.data(f"diagnosis {self.name} unusual", made)]

    @cached_property
    def evidence(self) -> Table:
        """Evidence of a leak over time, with it and without, as `evidence_over_time`; the fault's name is in its info."""

        def made() -> Table:
            self.lab.say(f"watch {self.name}, evidence over time")
            faults = one_of_each_kind(faults_watched(self.case))
            number, kind = next((n, k) for n, k in enumerate(faults) if fault_kind(k.name) == DRAWN)
            table = evidence_over_time(self.case, kind, FAULT_SEED + number)
            return Table(table.columns, table.units, {"fault": kind.name})

        return self.lab.computed.table(f"diagnosis {self.name} evidence", made)

    @property
    def seconds(self) -> int:
        """Healthy ones that were judged, those before faults among them."""
        return sum(h.seconds for h in self.healthy) + sum(f.judged_before for f in self.found)

    @property
    def false_alarms(self) -> int:
        """In these seconds."""
        return sum(len(h.named) for h in self.healthy) + sum(f.alarms_before for f in self.found)


def diagnoses(lab: Lab) -> list[Diagnosis]:
    """The lab's excavator, and a wheel loader."""
    machines = {"excavator": lab.machine, "wheel loader": load_machine("wheel_loader")}
    made = [Diagnosis(lab, machine, name) for name, machine in machines.items()]
    found: list[Diagnosis] = lab.computed.memory.setdefault("diagnoses", made)
    return found


def one_of_each_kind(faults: list[FaultKind]) -> list[FaultKind]:
    """Of each kind one fault: of the first kind the first that the catalogue has, of the second the second, and so on around."""
    kinds: dict[str, list[FaultKind]] = {}
    for fault in faults:
        kinds.setdefault(fault_kind(fault.name), []).append(fault)
    return [alike[number % len(alike)] for number, alike in enumerate(kinds.values())]
