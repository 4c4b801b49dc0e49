"""CSV logs: text files of columns, in one group of rows; see `polydraulic.columns` for what they may look like."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from polydraulic.columns.text_file import TextFile
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import Log, LogBlock, Signal, once


def open_csv(path: Path, dates: str | None = None) -> Log:
    """Open a CSV log; see `polydraulic.measure.formats.logs.open_log`."""
    file = TextFile(path, dates)
    signals, twice = once([_signal(file, n) for n in range(len(file.names))])

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        for block in file.read(wanted, time, findings):
            yield LogBlock(*block)

    # as their heads may have them
    forms = ("{} ({})", "{}/{}", "{}/({})", "{} in {}", "{}, {}", "{} - {}", "{} <{}>", "{} {{{}}}", "[{1}] {0}")
    also = {form.format(s.name, s.unit): s for s in signals if s.unit for form in forms}
    return Log(path, signals, False, read, twice, also=also)


def _signal(file: TextFile, place: int) -> Signal:
    name = file.names[place]
    if file.place(name) != place:
        return Signal(name, file.units[place], 0)
    kind = file.kind(name)
    return Signal(name, file.units[place], 0, kind, file.date_beside(name) or "", file.order_in_doubt(name))
