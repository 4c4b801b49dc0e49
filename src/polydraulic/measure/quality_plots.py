"""Pictures of the quality report, as SVG to be set into the page."""

from collections.abc import Mapping, Sequence
from io import StringIO
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.display import as_drawn, readable, time_axis, with_unit
from polydraulic.measure.checks.channel_check import ChannelCheck, value_in
from polydraulic.measure.checks.coverage import Coverage
from polydraulic.units import Conversion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MAPS = 12
_SIGNAL = 1.1  # inches, of a channel with its name
_BAND = 0.73  # share of it that is the channel's
_MAP = (2.85, 2.4)  # inches
_INTERVALS = 350


def signals_svg(checks: Sequence[ChannelCheck], units: Mapping[str, Conversion], began: float = 0.0) -> str:
    """Smallest and largest value of each channel over time, a band each; gaps are blank.

    Parameters
    ----------
    checks : sequence of ChannelCheck
    units : mapping from column to Conversion
        Units to show them in.
    began : float, s since 1970
        When the log's time was zero, if that is known: times are dates then.
    """
    from matplotlib.figure import Figure

    shown = [check for check in checks if check.count]
    if not shown:
        return ""
    width, height = 11.0, _SIGNAL * len(shown) + 0.55
    figure = Figure(figsize=(width, height))
    # bands of one plot, since matplotlib takes as long for each of its axes as for all that is drawn here
    axis = figure.add_axes((0.75 / width, 0.5 / height, (width - 0.95) / width, _SIGNAL * len(shown) / height))
    beside = axis.get_yaxis_transform()
    for base, check in zip(reversed(range(len(shown))), shown, strict=True):
        c, unit = check.channel, units[check.channel.name]
        first, last, low, high = _with_gaps(check.envelope.intervals(), check.raster)
        low, high = (value_in(check, unit, values) for values in (low, high))
        time, label = time_axis(np.column_stack([first, last]).ravel(), began)
        least, most = (value_in(check, unit, end) for end in (check.low, check.high))
        margin = 0.3 * (check.high - check.low)
        near = [limit for limit in (c.low, c.high) if check.low - margin <= limit <= check.high + margin]
        limits = [value_in(check, unit, limit) for limit in near]
        ends = min([least, *limits]), max([most, *limits])
        low, high = _in_band(low, ends, base), _in_band(high, ends, base)
        axis.axhspan(base, base + _BAND, color="#f4f4f4", linewidth=0.0)
        axis.fill_between(time, np.repeat(low, 2), np.repeat(high, 2), color="#2a6fb0", linewidth=0.6, zorder=2.0)
        for limit in limits:
            axis.axhline(_in_band(limit, ends, base), color="#c33", linewidth=0.8)
        for end in {least, most}:
            at, text = _in_band(end, ends, base), readable(end, 3)
            axis.text(-0.004, at, text, transform=beside, ha="right", va="center", fontsize="small")
        source = "" if c.source == c.name else f"   ({c.source})"
        title = as_drawn(with_unit(c.name, unit.unit) + source)
        axis.text(0.0, base + _BAND + 0.03, title, transform=beside, va="bottom", fontsize="small")
    axis.set_xlabel(label)
    axis.set_ylim(0.0, len(shown))
    axis.set_yticks([])
    axis.margins(x=0.01)
    axis.tick_params(labelsize="small")
    axis.grid(alpha=0.3)
    axis.spines[["left", "right", "top"]].set_visible(False)
    return _svg(figure, "signals")


def coverage_svg(found: Coverage, units: Mapping[str, Conversion]) -> str:
    """Rows by cell for pairs of inputs, those with the most empty cells first; holes are framed, and ends of ranges given."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    pairs = sorted(found.pairs, key=lambda pair: pair.share)[:_MAPS]
    columns = min(3, len(pairs))
    lines = -(-len(pairs) // columns)
    width, height = 3.7 * columns, 3.2 * lines
    figure = Figure(figsize=(width, height))
    # one plot in inches holds all maps, as above
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, width), ylim=(0.0, height))
    axis.set_axis_off()
    for place, pair in enumerate(pairs):
        line, column = divmod(place, columns)
        left, bottom = 3.7 * column + 0.7, 3.2 * (lines - 1 - line) + 0.5
        across = left + _MAP[0] * _shares(pair.x_edges, pair.x_edges)
        along = bottom + _MAP[1] * _shares(pair.y_edges, pair.y_edges)
        counts = pair.counts.T
        shade = np.ma.masked_array(np.log10(np.maximum(counts, 1)), counts == 0)
        axis.pcolormesh(across, along, shade, cmap="Blues", vmin=-1.0, edgecolors="white", linewidth=0.4)
        axis.add_patch(Rectangle((left, bottom), *_MAP, fill=False, linewidth=0.8))
        for hole in pair.holes:
            x = left + _MAP[0] * _shares(np.array(hole.x), pair.x_edges)
            y = bottom + _MAP[1] * _shares(np.array(hole.y), pair.y_edges)
            axis.add_patch(
                Rectangle((x[0], y[0]), x[1] - x[0], y[1] - y[0], fill=False, edgecolor="#c33", linewidth=1.2)
            )
        of_x, of_y = units[pair.x], units[pair.y]
        x_name, y_name = as_drawn(with_unit(pair.x, of_x.unit)), as_drawn(with_unit(pair.y, of_y.unit))
        axis.text(left, bottom + _MAP[1] + 0.05, f"{pair.share:.0%} of the cells", fontsize="small")
        axis.text(left + 0.5 * _MAP[0], bottom - 0.2, x_name, ha="center", va="top", fontsize="small")
        axis.text(
            left - 0.2, bottom + 0.5 * _MAP[1], y_name, ha="right", va="center", rotation="vertical", fontsize="small"
        )
        for end in (0, -1):
            x_text, y_text = (
                readable(float(of.from_si(edges[end])), 3) for of, edges in ((of_x, pair.x_edges), (of_y, pair.y_edges))
            )
            axis.text(across[end], bottom - 0.05, x_text, ha="center", va="top", fontsize="x-small")
            axis.text(left - 0.05, along[end], y_text, ha="right", va="center", fontsize="x-small")
    return _svg(figure, "coverage")


def _in_band(values: Any, ends: tuple[float, float], base: float) -> Any:
    """Values of a channel with these ends as heights in its band."""
    return base + _BAND * (values - ends[0]) / ((ends[1] - ends[0]) or 1.0)


def _shares(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """How far values lie between the first edge and the last."""
    shares: np.ndarray = (values - edges[0]) / (edges[-1] - edges[0])
    return shares


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
