"""Pictures of the quality report, as SVG to be set into the page."""

from collections.abc import Mapping, Sequence
from io import StringIO
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import as_drawn, time_axis, with_unit
from polydraulic.measure.checks.channel_check import ChannelCheck, value_in
from polydraulic.measure.checks.coverage import Coverage
from polydraulic.units import Conversion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MAPS = 12
_SIGNAL = 1.1  # inches, of a channel with its name
_INTERVALS = 350


def signals_svg(checks: Sequence[ChannelCheck], units: Mapping[str, Conversion], began: float = 0.0) -> str:
    """Smallest and largest value of each channel over time; gaps are blank.

    Parameters
    ----------
    checks : sequence of ChannelCheck
    units : mapping from column to Conversion
        Units to show them in.
    began : float, s since 1970
        When the log's time was zero, if that is known: times are dates then.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import FixedLocator, NullFormatter

    shown = [check for check in checks if check.count]
    if not shown:
        return ""
    width, height = 11.0, _SIGNAL * len(shown) + 0.55
    figure = Figure(figsize=(width, height))
    for place, check in enumerate(reversed(shown)):  # the lowest first: the others get its ticks
        c, unit = check.channel, units[check.channel.name]
        rectangle = (0.75 / width, (0.5 + _SIGNAL * place) / height, (width - 0.95) / width, (_SIGNAL - 0.3) / height)
        axis = figure.add_axes(rectangle)
        first, last, low, high = _with_gaps(check.envelope.intervals(), check.raster)
        low, high = (value_in(check, unit, values) for values in (low, high))
        time, label = time_axis(np.column_stack([first, last]).ravel(), began)
        axis.fill_between(time, np.repeat(low, 2), np.repeat(high, 2), color="#2a6fb0", linewidth=0.6)
        margin = 0.3 * (check.high - check.low)
        for limit in (c.low, c.high):
            if check.low - margin <= limit <= check.high + margin:
                axis.axhline(value_in(check, unit, limit), color="#c33", linewidth=0.8)
        source = "" if c.source == c.name else f"   ({c.source})"
        axis.set_title(as_drawn(with_unit(c.name, unit.unit) + source), loc="left", fontsize="small", pad=2.0)
        axis.tick_params(labelsize="small")
        axis.grid(alpha=0.3)
        if place == 0:
            axis.set_xlabel(label)
    axes = figure.axes
    ends = np.array([axis.get_xlim() for axis in axes])
    axes[0].set_xlim(ends[:, 0].min(), ends[:, 1].max())
    for axis in axes[1:]:
        axis.xaxis.set_major_locator(FixedLocator(axes[0].get_xticks().tolist()))
        axis.xaxis.set_major_formatter(NullFormatter())
        axis.set_xlim(axes[0].get_xlim())
    return _svg(figure, "signals")


def coverage_svg(found: Coverage, units: Mapping[str, Conversion]) -> str:
    """Rows by cell for pairs of inputs, those with the most empty cells first; holes are framed."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    pairs = sorted(found.pairs, key=lambda pair: pair.share)[:_MAPS]
    columns = min(3, len(pairs))
    lines = -(-len(pairs) // columns)
    width, height = 3.7 * columns, 3.2 * lines
    figure = Figure(figsize=(width, height))
    axes = [
        figure.add_axes(
            ((3.7 * column + 0.7) / width, (3.2 * (lines - 1 - line) + 0.5) / height, 2.85 / width, 2.4 / height)
        )
        for line in range(lines)
        for column in range(columns)
    ][: len(pairs)]
    for axis, pair in zip(axes, pairs, strict=True):
        counts = pair.counts.T
        shade = np.ma.masked_array(np.log10(np.maximum(counts, 1)), counts == 0)
        x, y = units[pair.x], units[pair.y]
        axis.pcolormesh(
            x.from_si(pair.x_edges),
            y.from_si(pair.y_edges),
            shade,
            cmap="Blues",
            vmin=-1.0,
            edgecolors="white",
            linewidth=0.4,
        )
        for hole in pair.holes:
            (left, right), (low, high) = map(x.from_si, hole.x), map(y.from_si, hole.y)
            axis.add_patch(
                Rectangle((left, low), right - left, high - low, fill=False, edgecolor="#c33", linewidth=1.2)
            )
        for label, name in ((axis.set_xlabel, pair.x), (axis.set_ylabel, pair.y)):
            label(as_drawn(with_unit(name, units[name].unit)), fontsize="small")
        axis.set_title(f"{pair.share:.0%} of the cells", loc="left", fontsize="small")
        axis.tick_params(labelsize="x-small")
    return _svg(figure, "coverage")


def _with_gaps(intervals: np.ndarray, raster: float) -> np.ndarray:
    """Few intervals, with a blank one in each gap."""
    step = max(1, -(-intervals.shape[1] // _INTERVALS))
    starts = np.arange(0, intervals.shape[1], step)
    ends = np.minimum(starts + step, intervals.shape[1]) - 1
    first, last = intervals[0, starts], intervals[1, ends]
    low, high = np.minimum.reduceat(intervals[2], starts), np.maximum.reduceat(intervals[3], starts)
    if not np.isfinite(raster) or len(first) == 0:
        return np.stack([first, last, low, high])
    across = last - first > 2.0 * float(np.median(last - first)) + 10.0 * raster  # a gap lies within
    low, high = np.where(across, np.nan, low), np.where(across, np.nan, high)
    gaps = np.flatnonzero(first[1:] - last[:-1] > 10.0 * raster) + 1
    middle = 0.5 * (first[gaps] + last[gaps - 1])
    blank = np.full(len(gaps), np.nan)
    parts = ((first, middle), (last, middle), (low, blank), (high, blank))
    return np.stack([np.insert(values, gaps, new) for values, new in parts])


def _svg(figure: "Figure", salt: str) -> str:
    import matplotlib

    text = StringIO()
    with matplotlib.rc_context({"svg.hashsalt": salt, "svg.fonttype": "none"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]
