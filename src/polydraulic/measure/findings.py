"""What is wrong with a log: kinds of finding, each counted, with the rows where it was seen first."""

from dataclasses import dataclass, field

import numpy as np

from polydraulic.errors import InputError

SHOWN = 20  # spans of rows that are kept of each kind and channel

# kind -> (level, what it means and what was done about it)
KINDS = {
    "missing line": ("error", "lines with too few or too many fields; left out"),
    "short line": (
        "warning",
        "lines with fewer fields than others, as many of this log have; missing fields are missing values",
    ),
    "cut line": (
        "warning",
        "the file ends in the middle of a line, behind a value with fewer decimals or digits than those before: it may be cut off; left out",
    ),
    "header": ("warning", "rows have more fields than the header has names"),
    "comment": ("warning", "lines of comment between the rows; left out"),
    "no time": ("error", "rows without a readable time; left out"),
    "clock jump": ("error", "single times that jump away and come back; left out"),
    "time repeats": ("error", "rows with the time of the row before; left out"),
    "overlap": ("error", "rows from times that were recorded already; left out"),
    "impossible time": (
        "error",
        "times before 1980 or after 2100: the logger's clock was not set, or its unit is wrong; those beyond any calendar are left out",
    ),
    "midnight": ("warning", "times of day pass midnight; taken as those of the next day"),
    "counter": ("warning", "the counter of the time ran over; taken to go on"),
    "twelve hours": ("warning", "times of a clock of twelve hours"),
    "clock change": ("warning", "times step by an hour: the clock was changed, as for summer time"),
    "files begin anew": (
        "warning",
        "files of one campaign whose times restart; each is put behind the one before, with a gap",
    ),
    "files overlap": ("error", "files of one campaign with the same times"),
    "file repeats": ("error", "files with the same rows as another one; left out"),
    "units of files": (
        "error",
        "files of one campaign give different units; that of the map was taken for all of them",
    ),
    "gap": ("warning", "no row for longer than samples may be apart; the table has a new segment after it"),
    "irregular": ("warning", "intervals between samples differ by more than a quarter of the usual one"),
    "raster": (
        "error",
        "samples come at another interval than the map says, or are far more or fewer than rows of the table",
    ),
    "duplicate": ("error", "the log has this name more than once; the first was taken"),
    "unit": ("error", "the log and the map give different units; the map's was taken"),
    "atmosphere": (
        "warning",
        "absolute pressures, and the map has no atmosphere; the standard one was subtracted",
    ),
    "text": ("error", "values that are not numbers; taken as missing"),
    "status": ("warning", "text in place of values, such as 'error' or 'not available'; taken as missing"),
    "short frame": ("error", "frames shorter than their message; signals beyond their end are missing"),
    "stamps": (
        "warning",
        "messages whose header gives another time than that of their receipt; the header's was taken",
    ),
    "unstamped": ("warning", "headers without a time; times of receipt were taken"),
    "not read": ("warning", "parts of the log that are not channels with rows and a time; left out"),
    "thousands": ("warning", "numbers with thousands separators; the whole column is read that way"),
    "decimal mark": ("error", "decimal points and decimal commas in one column; the rarer are taken as missing"),
    "doubtful numbers": ("warning", "three digits behind every mark: thousands, or decimals; taken as decimals"),
    "on and off": ("warning", "words for on and off; taken as 1 and 0"),
    "infinite": (
        "error",
        "infinite values, and numbers beyond 1e30, which loggers write for no value; taken as missing",
    ),
    "empty": ("error", "no value at all"),
    "constant": ("warning", "one value throughout: the sensor is dead, or nothing moved"),
    "dropout": (
        "warning",
        "no value for longer than samples may be apart; the table has no rows there, a partial one no values of this channel",
    ),
    "implausible": ("error", "values beyond the plausible range; taken as missing"),
    "unit by values": ("error", "most values are beyond the plausible range, and would fit in another unit"),
    "sign": ("error", "most values are beyond the plausible range, and would fit with the other sign"),
    "turns": (
        "warning",
        "an angle that begins anew after a full turn, as from 359 to 0 degrees; taken to go on past it",
    ),
    "spike": ("warning", "single values far from both neighbours; taken as missing"),
    "sentinel": (
        "error",
        "one number, again and again, far beyond all others: it may stand for no value; kept: say the range of the channel in the map",
    ),
    "frozen": ("warning", "one value held for long, where the channel never does so elsewhere"),
    "clipped": ("warning", "the largest or smallest value is held again and again: beyond the sensor's range"),
    "coarse": ("warning", "the channel takes few different values: steps as large as the signal"),
    "copy": ("warning", "the same numbers as another channel"),
    "no rows": ("error", "no time at which all inputs and outputs are known"),
}


@dataclass
class Finding:
    """One kind of fault in one channel (or in the clock, or the log as a whole).

    Attributes
    ----------
    kind : str
        A key of `KINDS`.
    channel : str
        Source name; empty for the log as a whole.
    count : int
        Rows concerned, of dropouts gaps; 0 where it is not about rows.
    rows : list of (first, last)
        Spans of rows, the first `SHOWN` of them; of dropouts the row after each gap. Rows of data are counted from 1, in an MDF file within their group.
    detail : str
        What else there is to say.
    """

    kind: str
    channel: str
    count: int = 0
    rows: list[tuple[int, int]] = field(default_factory=list)
    detail: str = ""

    @property
    def level(self) -> str:
        """``"error"`` or ``"warning"``."""
        return KINDS[self.kind][0]

    def __str__(self) -> str:
        spans = ", ".join(str(a) if a == b else f"{a} to {b}" for a, b in self.rows[:5])
        many = "s" if self.count > 1 else ""
        what, place = ("gap", "before") if self.kind == "dropout" else ("row", "in")
        where = f" {place} row{many} {spans}" if self.rows else ""
        more = ", ..." if len(self.rows) > 5 else ""
        rows = f" ({self.count} {what}{many})" if self.count else ""
        detail = f"; {self.detail}" if self.detail else ""
        of = f" {self.channel!r}" if self.channel else ""
        return f"{self.kind}{of}{rows}{where}{more}: {KINDS[self.kind][1]}{detail}"


class Findings:
    """Findings as they come in, block by block."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], Finding] = {}
        self._expected: dict[tuple[str, str], str] = {}

    def __iter__(self):  # type: ignore[no-untyped-def]
        order = {"error": 0, "warning": 1}
        return iter(sorted(self._found.values(), key=lambda f: order[f.level]))

    def __len__(self) -> int:
        return len(self._found)

    def add(self, kind: str, channel: str = "", detail: str = "") -> Finding:
        """Note something that is not about single rows."""
        found = self._found.setdefault(
            (kind, channel), Finding(kind, channel, detail=self._expected.get((kind, channel), ""))
        )
        found.detail = detail or found.detail
        return found

    def expect(self, kind: str, channel: str, detail: str) -> None:
        """Keep the detail of a finding that may come: what is wrong with rows that have no time is none."""
        self._expected.setdefault((kind, channel), detail)

    def add_rows(self, kind: str, channel: str, rows: np.ndarray, detail: str = "") -> None:
        """Note rows (their numbers, rising)."""
        if rows.size == 0:
            return
        found = self.add(kind, channel, detail)
        found.count += int(rows.size)
        cuts = np.flatnonzero(np.diff(rows) > 1)[:SHOWN]
        starts, ends = np.concatenate([[0], cuts + 1]), np.concatenate([cuts, [rows.size - 1]])
        for first, last in zip(rows[starts].tolist(), rows[ends].tolist(), strict=True):
            if found.rows and first == found.rows[-1][1] + 1:
                found.rows[-1] = (found.rows[-1][0], last)
            elif len(found.rows) < SHOWN:
                found.rows.append((first, last))

    def add_span(self, kind: str, channel: str, first: int, last: int, count: int, detail: str = "") -> None:
        """Note one span of rows, of which `count` are concerned."""
        found = self.add(kind, channel, detail)
        found.count += count
        if len(found.rows) < SHOWN:
            found.rows.append((first, last))

    def of(self, kind: str, channel: str | None = None) -> list[Finding]:
        """Findings of one kind."""
        if kind not in KINDS:
            raise InputError(f"no finding is called {kind!r}; there are {list(KINDS)}")
        return [f for f in self if f.kind == kind and channel in (None, f.channel)]
