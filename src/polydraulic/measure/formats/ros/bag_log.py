"""Bags of ROS 2 (a folder, MCAP, SQLite) and ROS 1: topics whose messages hold numbers are groups with a clock of their own.

A bag is read once: the numbers of each topic go to a file, from which blocks are read. The time of a message is that of its header,
where it has one; otherwise the time of its receipt.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.files import Scratch
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import Log, LogBlock, Signal
from polydraulic.measure.formats.ros.bag import Bag, full_name, opened_bag, unfinished
from polydraulic.measure.formats.ros.fields import Fields
from polydraulic.measure.formats.ros.topic_rows import MOST, TopicRows

_LATE = 0.1  # s between header and receipt that are worth a word
_DATES = 315_532_800 * 10**9  # ns since 1970: before 1980 a clock is none of dates
_EXACT = 2.0**53  # integers from it on are no numbers of double precision


class _Topic:
    """A topic while its messages come in: rows, and how header and receipt differ."""

    def __init__(self, label: str, kind: str, fields: Fields, rows: TopicRows) -> None:
        self.label, self.kind, self.fields, self.rows = label, kind, fields, rows
        self.seen = self.damaged = self.unstamped = 0
        self.least, self.most = np.inf, -np.inf  # s from header to receipt
        self.first_stamp = np.inf  # s since 1970

    @property
    def stamped(self) -> bool:
        """Whether headers give the time: at least one of them does."""
        return self.fields.stamped and self.unstamped < self.rows.n_row

    def add(self, message: Any, receipt: int, zero: int) -> None:
        """Add a message, received this many ns since 1970; times are kept from `zero` on."""
        layout, values = self.fields.row(message)
        if not self.rows.knows(layout) and not self.rows.add_layout(layout, self.fields.columns(layout)):
            self.rows.too_many += 1
            return
        stamp = np.nan
        if self.fields.stamped:
            time = message.header.stamp
            nanoseconds = int(time.sec) * 10**9 + int(time.nanosec)
            if nanoseconds == 0:
                self.unstamped += 1
            else:
                stamp = (nanoseconds - zero) * 1e-9
                late = (receipt - nanoseconds) * 1e-9
                self.least, self.most = min(self.least, late), max(self.most, late)
                self.first_stamp = min(self.first_stamp, nanoseconds * 1e-9)
        self.rows.add(stamp, (receipt - zero) * 1e-9, layout, values)

    def note(self, findings: Findings) -> None:
        """Say how the times of headers and of receipt differ."""
        if not self.fields.stamped:
            return
        if not self.stamped:
            findings.add("unstamped", self.label)
        elif max(abs(self.least), abs(self.most)) > _LATE:
            findings.add("stamps", self.label, f"received {self.least:.4g} to {self.most:.4g} s after their stamps")


def open_bag(path: Path) -> Log:
    """Open a bag.

    Parameters
    ----------
    path : Path
        The folder of a ROS 2 bag, one of its files (``.mcap``, ``.db3``), or a ROS 1 bag (``.bag``).

    Raises
    ------
    InputError
        A file that cannot be read, or no topic whose messages hold numbers.
    """
    scratch = Scratch()
    try:
        with scratch.writing(), opened_bag(path) as bag:
            topics, left_out = _topics(bag, scratch.folder)
            zero = _read(bag, topics)
            for key, topic in topics.items():
                if topic.seen < bag.said[key]:
                    left_out[f"{topic.label}: {bag.said[key] - topic.seen} of {bag.said[key]} messages"] = (
                        "not to be found in the bag"
                    )
        return _log(path, topics, left_out | unfinished(path), zero, scratch)
    except BaseException:
        scratch.close()
        raise


def _topics(bag: Bag, folder: Path) -> tuple[dict[tuple[str, str], _Topic], dict[str, str]]:
    """Topics that may hold numbers, by name and type; the others with the reason."""
    found: dict[tuple[str, str], _Topic] = {}
    left_out: dict[str, str] = {}
    names = [name for name, _ in bag.topics]
    for (name, kind), reason in bag.topics.items():
        label = name if names.count(name) == 1 else f"{name} ({kind})"
        if reason:
            left_out[label] = reason
            continue
        try:
            fields = Fields(bag.store(name, kind), full_name(kind))
        except Exception as error:  # rosbags raises errors of many kinds on definitions that contradict themselves
            left_out[label] = f"its type {kind} cannot be read: {error}"
            continue
        if fields.empty:
            others = ", ".join(f"{reason} ({field})" for field, reason in fields.left_out.items())
            left_out[label] = f"{kind} holds {others or 'no numbers'}"
        else:
            found[name, kind] = _Topic(label, kind, fields, TopicRows(folder / str(len(found))))
    return found, left_out


def _read(bag: Bag, topics: dict[tuple[str, str], _Topic]) -> int:
    """Read all messages; the time in ns since 1970 from which times are counted."""
    zero: int | None = None
    for key, receipt, message in bag.messages(list(topics)):
        topic = topics[key]
        topic.seen += 1
        if zero is None:
            zero = receipt // 10**9 * 10**9 if receipt > _DATES else 0
        if message is None:
            topic.damaged += 1
        else:
            topic.add(message, receipt, zero)
    for topic in topics.values():
        topic.rows.flush()
    return zero or 0


def _log(
    path: Path,
    topics: dict[tuple[str, str], _Topic],
    left_out: dict[str, str],
    zero: int,
    scratch: Scratch,
) -> Log:
    signals: list[Signal] = []
    groups: list[tuple[_Topic, list[int], set[str]]] = []
    whole: set[str] = set()
    also: dict[str, list[Signal]] = {}
    for topic in topics.values():
        parts = topic.rows.parts()
        for layouts, columns in parts:
            for column in columns:
                name = f"{topic.label}/{column.name}"
                signal = Signal(name, column.unit.unit, len(groups), other_unit=column.unit.other)
                signals.append(signal)
                for other in (name.removeprefix("/"), column.name):
                    also.setdefault(other, []).append(signal)
                if column.whole:
                    whole.add(name)
            groups.append((topic, layouts, {column.name for column in columns}))
        left_out |= _not_read(topic, parts)
    if not signals:
        why = "; ".join(f"{name}: {reason}" for name, reason in list(left_out.items())[:5]) or "it has no topics"
        raise InputError(f"{path}: the log has no topic whose messages hold numbers: {why}")
    # stamps of a simulation begin at 0: its times are their own, not counted from a date
    dated = zero > 0 and all(t.first_stamp * 1e9 > _DATES for t in topics.values())
    shift = 0.0 if dated else zero * 1e-9

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        topic, layouts, _ = groups[group]
        own = [name if name in canonical else known[name].name for name in wanted]
        fields = [name.removeprefix(f"{topic.label}/") for name in own]
        topic.note(findings)
        begun = 0
        for at, values, done in topic.rows.blocks(layouts, fields, stamped=topic.stamped):
            rows = np.arange(begun, begun + len(at)) + 1
            begun += len(at)
            block: dict[str, np.ndarray] = {}
            text: dict[str, np.ndarray] = {}
            for name, full, field in zip(wanted, own, fields, strict=True):
                beyond = np.abs(values[field]) >= _EXACT if full in whole else np.zeros(len(at), dtype=bool)
                block[name] = np.where(beyond, np.nan, values[field])
                text[name] = np.flatnonzero(beyond)
            yield LogBlock(rows, at + shift, block, text, done)

    canonical = {signal.name for signal in signals}
    known = {name: of[0] for name, of in also.items() if len(of) == 1 and name not in canonical}
    return Log(
        path,
        signals,
        True,
        read,
        close=scratch.close,
        began=zero * 1e-9 if dated else 0.0,
        also=known,
        left_out=left_out,
    )


def _not_read(topic: _Topic, parts: list[tuple[list[int], list[Any]]]) -> dict[str, str]:
    """What of a topic is left out, by name, with the reason."""
    found = {f"{topic.label}/{field}": reason for field, reason in topic.fields.left_out.items()}
    for field, n in topic.fields.uneven.items():
        found[f"{topic.label}/{field}: {n} of {topic.seen} messages"] = "not one value for each name"
    if topic.damaged:
        found[f"{topic.label}: {topic.damaged} of {topic.seen} messages"] = (
            "damaged, or not of the type that the bag says"
        )
    if topic.rows.too_many:
        found[f"{topic.label}: {topic.rows.too_many} of {topic.seen} messages"] = f"more than {MOST} columns"
    if not topic.seen:
        found[topic.label] = "no message"
    elif not parts and not found:
        found[topic.label] = f"no message of {topic.kind} holds a number"
    return found
