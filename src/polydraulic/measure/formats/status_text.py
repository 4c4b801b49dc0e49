"""Texts that a log has in place of numbers: which are states of a channel, and which say that there is no value.

A table of texts stands beside a scaling: 254 is "error", all else is 0.4 degC a bit. Such a text is no value of the channel. The
states of a switch (0 "off", 1 "on") come in the same kind of table, with a scaling by 1 that does nothing; their numbers are the
values. A switch is told by its table alone, never by the values that a file happens to hold.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.measure.findings import Findings

_NONE = {
    "error", "err", "error indicator", "not available", "not available or not installed", "n/a", "na", "sna", "snv", "invalid",
    "signal not available", "signal invalid", "signal error", "not defined", "undefined", "reserved", "not installed", "init",
    "don't care", "take no action", "fehler", "nicht verfügbar", "ungültig",
}  # fmt: skip
_NAMED = 6  # texts that a finding names


class StatusText(NamedTuple):
    """A text, and the raw values that it stands for: from `low` to `high`, both included."""

    low: float
    high: float
    text: str


def states(texts: Sequence[StatusText], *, scaled: bool, bits: int | None = None) -> list[bool]:
    """Which texts are names of states, so that their numbers are values.

    Parameters
    ----------
    texts : sequence of StatusText
    scaled : bool
        Whether other raw values are scaled or have a unit: the channel measures something.
    bits : int, optional
        Of the raw value; where the texts leave none of them without a name, the scaling says nothing.

    Returns
    -------
    list of bool
        One for each text. States are numbered from 0 without a hole, two at least; "error" and "not available" behind them are none.
    """
    numbers = {int(t.low) for t in texts if t.low == t.high and float(t.low).is_integer()}
    run = 0
    while run in numbers:
        run += 1
    if scaled and (bits is None or bits > 16 or run < 2**bits):
        run = 0
    inside = [t.low == t.high and 0 <= t.low < run for t in texts]
    kept = [i and not no_value(t.text) for i, t in zip(inside, texts, strict=True)]
    if sum(kept) >= 2:
        return kept
    return inside if run >= 2 else [False] * len(texts)


def no_value(text: str) -> bool:
    """Whether a text says for itself that there is no value, such as "error" or "not available"."""
    return text.strip().casefold() in _NONE


class StatusNotes:
    """Notes the rows of a channel whose values are texts, and which texts they are."""

    def __init__(self, channel: str, findings: Findings) -> None:
        self.channel, self.findings = channel, findings
        self._seen: dict[str, None] = {}

    def add(self, rows: np.ndarray, said: dict[str, np.ndarray]) -> None:
        """Note places in a block of rows by their text.

        Parameters
        ----------
        rows : (n,) array of int
            Numbers of the block's rows.
        said : dict from str to array of int
            Places of each text.
        """
        if not said:
            return
        self._seen |= dict.fromkeys(said)
        shown = ", ".join(map(repr, list(self._seen)[:_NAMED]))
        more = f" and {len(self._seen) - _NAMED} more" if len(self._seen) > _NAMED else ""
        self.findings.add_rows("status", self.channel, rows[np.sort(np.concatenate(list(said.values())))], shown + more)
