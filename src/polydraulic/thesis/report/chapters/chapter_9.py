"""Chapter 9, diagnosis: how soon faults are found in the logs of identified machines, how they are named, and false alarms."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.diagnosis import HEALTHY_LASTS, HEALTHY_LOGS, LEARNT, Diagnosis, diagnoses
from polydraulic.thesis.diagnosis_study import (
    BEGINS,
    DRIFTS,
    LASTS,
    SURE,
    WITHIN,
    WatchedFault,
    fault_kind,
    most_per_hour,
)
from polydraulic.thesis.report.catalog import Chapter, Content, Figure, Grid, Paragraph, result
from polydraulic.thesis.report.figures.draw import canvas
from polydraulic.watch.kernels.evidence import LEAST_BLOCKS
from polydraulic.watch.learning import FALSE_ALARMS

if TYPE_CHECKING:
    import matplotlib.figure

_UNNAMED = {
    "no occasion": "no occasion to show",
    "hidden": "hidden by errors of the identified machine",
    "missed": "missed",
}


def content(lab: Lab) -> Content:
    """Numbers of this chapter."""
    studies = diagnoses(lab)
    tables = [_delays(studies), _named_kinds(_of_all(studies)), _false_alarms(studies), _unusual(studies)]
    return Content(_text(studies), {}, _numbers(studies), tables)


def _of_all(studies: Sequence[Diagnosis]) -> list[WatchedFault]:
    return [found for study in studies for found in study.found]


def _alarmed(faults: Sequence[WatchedFault]) -> list[WatchedFault]:
    return [f for f in faults if f.named]


def _could(faults: Sequence[WatchedFault]) -> list[WatchedFault]:
    return [f for f in faults if f.could]


def _numbers(studies: Sequence[Diagnosis]) -> list[dict[str, Any]]:
    faults = _of_all(studies)
    could, alarmed = _could(faults), _alarmed(faults)
    alarms, seconds = sum(s.false_alarms for s in studies), sum(s.seconds for s in studies)
    rows = [
        result("polydraulic.diagnosis.false_alarms", "9", "false alarms in healthy work", "1", float(alarms)),
        result("polydraulic.diagnosis.healthy_h", "9", "healthy work that was judged", "h", seconds / 3600.0),
        result("polydraulic.diagnosis.most_per_hour", "9", f"false alarms per hour, at most, with {100.0 * SURE:.0f} % certainty", "1/h", most_per_hour(alarms, seconds)),
    ]  # fmt: skip
    if could:
        in_time = sum(f.outcome == "in time" for f in could) / len(could)
        rows.append(result("polydraulic.diagnosis.in_time_percent", "9", f"faults in their smallest sizes found within {WITHIN} s in which they can show", "%", 100.0 * in_time, f"of {len(could)} that had an occasion to show"))  # fmt: skip
    if alarmed:
        kinds = sum(fault_kind(f.named) == fault_kind(f.fault) for f in alarmed) / len(alarmed)
        rows += [
            result("polydraulic.diagnosis.delay_s", "9", "delay until a fault in its smallest size is found, median, in seconds in which it can show", "s", float(np.median([f.delay for f in alarmed]))),
            result("polydraulic.diagnosis.clock_s", "9", "delay until a fault in its smallest size is found, median, by the clock", "s", float(np.median([f.clock for f in alarmed]))),
            result("polydraulic.diagnosis.kind_percent", "9", "alarms that name the right kind of fault", "%", 100.0 * kinds, f"of {len(alarmed)} alarms"),
        ]  # fmt: skip
    return rows


def _delays(studies: Sequence[Diagnosis]) -> Grid:
    rows = [
        [
            study.name,
            f"{f.fault}: {f.title}",
            str(f.could_show),
            str(f.delay) if f.named else "\u2013",
            f"{f.clock:.0f}" if f.named else "\u2013",
            f.named or _UNNAMED[f.outcome],
        ]
        for study in studies
        for f in study.found
    ]
    header = [
        "machine",
        "fault, in the smallest size of its kind",
        "seconds in which it could show",
        "of these, until the alarm",
        "until the alarm, by the clock [s]",
        "named as",
    ]
    return Grid("Detection delay of a fault of each kind", header, rows)


def _named_kinds(faults: Sequence[WatchedFault]) -> Grid:
    rows = []
    for kind, counts in _confusion(faults).items():
        named = ", ".join(f"{name} ({count})" for name, count in counts.items())
        rows.append([_words(kind), str(counts.total()), named])
    return Grid("Kinds of faults, and the kinds that alarms name", ["kind", "logs", "named as (logs)"], rows)


def _confusion(faults: Sequence[WatchedFault]) -> dict[str, Counter[str]]:
    """Of each kind, how often which kind was named, in words."""
    found: dict[str, Counter[str]] = {}
    for f in faults:
        found.setdefault(fault_kind(f.fault), Counter())[
            _words(fault_kind(f.named)) if f.named else _UNNAMED[f.outcome]
        ] += 1
    return found


def _words(kind: str) -> str:
    return kind.replace("_", " ")


def _false_alarms(studies: Sequence[Diagnosis]) -> Grid:
    rows = [_false_row(study.name, [study]) for study in studies]
    header = [
        "machine",
        "healthy minutes judged",
        "false alarms",
        "named as",
        f"per hour, at most, with {100.0 * SURE:.0f} % certainty",
    ]
    return Grid("False alarms in healthy work", header, [*rows, _false_row("all", studies)])


def _false_row(name: str, studies: Sequence[Diagnosis]) -> list[str]:
    alarms, seconds = sum(s.false_alarms for s in studies), sum(s.seconds for s in studies)
    named = [name for s in studies for h in s.healthy for name in h.named]
    early = alarms - len(named)
    named += [f"{early} before faults"] if early else []
    return [
        name,
        f"{seconds / 60.0:.0f}",
        str(alarms),
        ", ".join(named) or "\u2013",
        f"{most_per_hour(alarms, seconds):.1f}",
    ]


def _unusual(studies: Sequence[Diagnosis]) -> Grid:
    rows = [[study.name, *row] for study in studies for row in study.unusual]
    return Grid("Unusual work without a fault, 90 s each", ["machine", "work", "named as"], rows)


def _text(studies: Sequence[Diagnosis]) -> list[Paragraph]:
    faults = _of_all(studies)
    could, alarmed = _could(faults), _alarmed(faults)
    none, hidden = ([f.fault for f in faults if f.outcome == outcome] for outcome in ("no occasion", "hidden"))
    few = sum(f.could_show < WITHIN for f in alarmed)
    late, missed = ([f.fault for f in faults if f.outcome == outcome] for outcome in ("late", "missed"))
    exact = sum(f.named == f.fault for f in alarmed)
    kinds = sum(fault_kind(f.named) == fault_kind(f.fault) for f in alarmed)
    alarms, seconds = sum(s.false_alarms for s in studies), sum(s.seconds for s in studies)
    delays = (
        f" Half of the alarms come within {np.median([f.delay for f in alarmed]):.0f} s in which the fault could show, "
        f"{np.median([f.clock for f in alarmed]):.0f} s by the clock; the last after {max(f.clock for f in alarmed):.0f} s. "
        f"{exact} of {len(alarmed)} name the fault itself, {kinds} its kind."
        if alarmed
        else ""
    )
    return [
        Paragraph(
            "In its first chapter the thesis names a use for a simulation that is fast: embedded into a fault and hazard diagnosis system. This "
            "chapter asks what such a system finds of faults. A machine's simulation says what its sensors should read; what they read beyond that is "
            "compared with what each fault of a catalogue would do. The hazard that the thesis has in mind, tipping over, is no part of this "
            "chapter (docs/stability.md).",
            "Why.",
        ),
        Paragraph(
            "Two simulated machines, the excavator of the other chapters and a wheel loader, with sensors of spools, port pressures, flows, joint angles and "
            f"levers, all with noise. Each machine is identified from {LEARNT / 60.0:g} min of its own healthy work, beginning from valve curves that are off by up to "
            "half, pumps and pilots by 5 to 20 %; the identified machine, not the true one, is watched. Of each kind of fault one is taken, in the smallest size of the catalogue, functions and "
            f"sensors by turns. It begins {BEGINS:g} s into the log of an operator of its own and stays for {LASTS:g} s; the drift of a sensor, which takes ten minutes to its size, for {DRIFTS:g} s. Nothing was chosen by these operators.",
            "What was done.",
        ),
        Paragraph(
            "A fault shows only where the machine's work lets it: a relief valve that is set low needs a pressure near to it. It can show in a second in which it "
            "would move what is read by a standard deviation at least; noise and the errors of the identified machine count alike, and where these stray by so much from one minute to the next that a minute of it would "
            "give no alarm, no second counts. The delay is given in such seconds, "
            f"and by the clock; no second counts for more than 1/{LEAST_BLOCKS} of what makes an alarm, so that {LEAST_BLOCKS} of them are about the least. An alarm goes on diagnosing for up to a minute; its name is the last that it gives.",
            "How to read the tables.",
        ),
        Paragraph(
            f"Of {len(faults)} faults {sum(f.outcome == 'in time' for f in could)} were found within {WITHIN} s in which they could show; found later: {_count(late)}; "
            f"not found although they had as long: {_count(missed)}. Counted apart are those with less than {WITHIN} s in which they could show, and no alarm. The work "
            f"gave no occasion to: {_count(none)}. It would have given one if the identified machine had no errors to: {_count(hidden)}. "
            f"Of those that were found {few} had less than {WITHIN} s, too.{delays}",
            "What was found.",
        ),
        Paragraph(
            f"The tests are set to {FALSE_ALARMS:g} false alarms per hour. In {seconds / 60.0:.0f} healthy minutes ({HEALTHY_LOGS} logs of {HEALTHY_LASTS / 60.0:g} min of each machine, "
            f"and the time before each fault; seconds next to a gap in what a sensor reads are not judged) there {_were(alarms)}. So few minutes cannot confirm that setting: they "
            f"only show, with {100.0 * SURE:.0f} % certainty, that there are at most {most_per_hour(alarms, seconds):.1f} in an hour.",
            "False alarms.",
        ),
        Paragraph(
            "No real machine was watched. The true machines obey the equations of the identified ones, whose curves and numbers differ; logs are of random operators; faults are "
            "single and stay, and but for drifts they begin at once; each was tried once. docs/diagnosis.md has the method, a larger study in which "
            "the true machine also has hysteresis, flow forces and friction that holds, of which the watched one knows nothing, and what the method cannot do.",
            "What was not measured.",
        ),
    ]


def _count(faults: Sequence[str]) -> str:
    return f"{len(faults)} ({', '.join(faults)})" if faults else "none"


def _were(alarms: int) -> str:
    return {0: "was none", 1: "was one"}.get(alarms, f"were {alarms}")


def evidence(lab: Lab) -> Figure:
    """Evidence of a leak over time, next to the same work of the healthy machine."""
    data = {study.name: study.evidence for study in diagnoses(lab)}

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, len(data), width=5.4 * len(data), height=3.4)
        for axis, (name, table) in zip(axes[0], data.items(), strict=True):
            fault = str(table.info["fault"])
            lines = {
                "faulty.own": (f"{fault}, with it", "C3", "-", 1.8),
                "healthy.own": (f"{fault}, healthy", "C0", "-", 1.8),
                "healthy.most": ("the most of all faults, healthy", "C0", ":", 1.0),
            }
            for column, (label, color, style, width) in lines.items():
                axis.plot(table["time"], table[column], style, color=color, linewidth=width, label=label)
            axis.axhline(1.0, color="0.2", linestyle="--", linewidth=1.0, label="alarm")
            axis.axvline(BEGINS, color="0.5", linewidth=1.0)
            axis.annotate(
                "begins", (BEGINS, 1.95), xytext=(3, 0), textcoords="offset points", fontsize="small", va="top"
            )
            axis.set_ylim(0.0, 2.1)
            axis.set_xlabel("time [s]")
            axis.set_ylabel("evidence / threshold")
            axis.set_title(name, fontsize="medium")
            axis.grid(alpha=0.3)
            axis.legend(fontsize="small", loc="center right")
        return figure

    see = (
        "The same operator works twice on each machine, with a leak from line to line in its smallest size and without. Evidence is that of the leak since it may have begun, as a "
        "share of what makes an alarm, and is kept from rising beyond twice that; dotted: the most that any fault gets of the healthy machine."
    )
    return Figure("Evidence of a leak over time, next to that of healthy work", see, data, draw)


def confusion(lab: Lab) -> Figure:
    """Kind of fault against the kind that alarms name."""
    counts = _confusion(_of_all(diagnoses(lab)))
    kinds = [_words(kind) for kind in counts]
    others = [name for name in dict.fromkeys(n for c in counts.values() for n in c) if name not in kinds]
    heads = [*kinds, *(name for name in others if name not in _UNNAMED.values()), *_UNNAMED.values()]
    values = np.array([[c[name] for name in heads] for c in counts.values()], dtype=float)
    table = Table({"row": np.arange(1.0, len(kinds) + 1.0), **dict(zip(heads, values.T, strict=True))}, {})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=8.4, height=6.0)
        axis = axes[0, 0]
        axis.imshow(values, cmap="Blues", vmin=0.0, vmax=1.5 * values.max(), aspect="auto")
        for row, column in np.argwhere(values > 0.0).tolist():
            axis.text(column, row, f"{values[row, column]:.0f}", ha="center", va="center")
        axis.set_xticks(range(len(heads)), heads, rotation=60, ha="right", rotation_mode="anchor")
        axis.set_yticks(range(len(kinds)), kinds)
        axis.axvline(len(heads) - len(_UNNAMED) - 0.5, color="0.3", linewidth=1.0)
        axis.set_xlabel("named as")
        axis.set_ylabel("kind of fault")
        return figure

    see = (
        "How many logs with a fault of a kind (rows) gave an alarm that names which kind (columns), on both machines together; right of the line: logs without an alarm. "
        "Rows of the data are in the order of the columns."
    )
    return Figure("Kind of fault against the kind that is named", see, {"": table}, draw)


CHAPTER = Chapter(
    9,
    "Diagnosis",
    "Faults found in the logs of machines that were identified from measurements: how soon, by what name, and how often by mistake.",
    content,
    {"9-1": evidence, "9-2": confusion},
)
