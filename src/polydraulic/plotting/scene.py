"""A machine in motion as matplotlib draws it: side view, view from above, and joint positions over time.

Artists that change from frame to frame are marked as animated, so that a writer can draw the others once.
"""

from collections.abc import Callable, Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.plotting.carrier import INK
from polydraulic.plotting.drawing import (
    AT_STOP,
    OF_RUN,
    OPEN,
    Drawing,
    DrawnMotion,
    Outline,
    View,
    motion_of,
    places,
    seen,
    silhouette,
    view_limits,
)
from polydraulic.plotting.frames import Frames, PlottedChannel
from polydraulic.plotting.run_figure import line_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIRST_EDGE, STOP = "#3b6ea5", "#c0392b"
CAPTIONS: dict[View, str] = {
    "side": "side view, in the plane of the arm; ticks are end stops, red when reached",
    "top": "from above",
}
_STRIPS_IN_A_ROW = 5
Update = Callable[[int], None]


def moving_artists(figure: "Figure") -> list[Any]:
    """Artists that change from frame to frame, lowest first."""
    return sorted(figure.findobj(lambda artist: artist.get_animated()), key=lambda artist: artist.get_zorder())


def scene(frames: Frames, drawing: Drawing) -> tuple["Figure", Update]:
    """Return a scene without moving parts, and the function that puts them where they are in a frame."""
    from matplotlib.figure import Figure

    shown = [c for c in frames.channels if c.title in ("angle", "position", "tip height", "tip from first")]
    shown = shown[:-2] + shown[-1:] if len(frames.names) > 1 else shown
    rows = ceil(len(shown) / _STRIPS_IN_A_ROW)
    height, below = 5.0 + 1.2 * rows, 0.474 + 1.2 * rows  # in
    figure = Figure(figsize=(9.6, height))
    side = figure.add_axes((0.01, below / height, 0.6, 4.154 / height))
    top = figure.add_axes((0.62, below / height, 0.37, 4.154 / height))
    motions = [motion_of(drawing, positions) for positions in frames.positions]
    updates: list[Update] = []
    views: list[tuple[Axes, View]] = [(side, "side"), (top, "top")]
    for axis, view in views:
        fill_place(axis, *view_limits(drawing, motions, view))
        _frameless(axis, CAPTIONS[view], drawing.scale)
        updates += [draw_view(axis, drawing, view, motions), _trails(axis, motions, frames.effector, view)]
    updates += _strips(figure, frames, shown, ceil(len(shown) / rows))
    clock = figure.text(0.985, 1.0 - 0.267 / height, "", ha="right", family="monospace", fontsize=11, animated=True)
    figure.text(0.015, 1.0 - 0.267 / height, frames.title, fontweight="bold", fontsize=11)
    for number, name in enumerate(frames.names):
        color = FIRST_EDGE if number == 0 else line_style(number)[0]
        figure.text(0.25 + 0.14 * number, 1.0 - 0.267 / height, f"\u25a0 {name}", color=color, fontsize=10)

    def update(k: int) -> None:
        clock.set_text(f"{frames.time[k]:6.2f} s")
        for part in updates:
            part(k)

    return figure, update


def draw_view(axis: "Axes", drawing: Drawing, view: View, motions: Sequence[DrawnMotion]) -> Update:
    """Draw a machine as one run moves it, or several, on an axis with limits: the first filled, the others as outlines."""
    if view == "side":
        axis.axhspan(axis.get_ylim()[0], drawing.ground, color="#f3efe8", linewidth=0.0, zorder=0)
        axis.axhline(drawing.ground, color="#b8ad9a", linewidth=1.0, zorder=0)
    bodies = [body for body in drawing.bodies if view in body.views]
    updates = [_body(axis, body, view, motions[0], 0) for body in bodies if body.fill not in (OF_RUN, OPEN)]
    updates += [_stops(axis, drawing, view, motions[0])]
    for number in reversed(range(len(motions))):
        motion = motions[number]
        updates += [_body(axis, body, view, motion, number) for body in bodies if body.fill in (OF_RUN, OPEN)]
        if view == "side":
            updates += [_rams(axis, drawing, motion, number), _pins(axis, drawing, motion, number)]

    def update(k: int) -> None:
        for part in updates:
            part(k)

    return update


def fill_place(axis: "Axes", low: np.ndarray, high: np.ndarray) -> None:
    """Equal scales; the view is widened to fill its place, a little more to the upper right."""
    width, height = axis.get_window_extent().size
    scale = max((high - low) / (width, height))
    spare = scale * np.array([width, height]) - (high - low)
    low, high = low - 0.4 * spare, high + 0.6 * spare
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])


def _frameless(axis: "Axes", title: str, bar: float) -> None:
    """No frame, and a bar of a round length."""
    axis.axis("off")
    (x, right), y = axis.get_xlim(), axis.get_ylim()[0]
    scale = (right - x) / axis.get_window_extent().width
    left, bottom = x + 14.0 * scale, y + 12.0 * scale
    axis.plot([left, left + bar], [bottom, bottom], color=INK, linewidth=2.0)
    text = f"{bar:g} m"
    axis.text(left + 0.5 * bar, bottom + 4.0 * scale, text, ha="center", va="bottom", fontsize=8, color=INK)
    axis.text(0.02, 0.98, title, transform=axis.transAxes, va="top", fontsize=8.5, color="0.45")


def _edge(number: int) -> str:
    return line_style(number)[0] if number else FIRST_EDGE


def _layer(number: int) -> int:
    return 5 if number else 3


def _body(axis: "Axes", body: Outline, view: View, motion: DrawnMotion, number: int) -> Update:
    from matplotlib.patches import Polygon

    points = seen(motion, view, places(motion, body.spots))
    if body.fill in (OF_RUN, OPEN):
        filled = body.fill == OF_RUN and not number
        style: dict[str, Any] = {
            "edgecolor": _edge(number),
            "linewidth": 1.3 if number else 1.2,
            "zorder": _layer(number),
        }
        style["facecolor"] = line_style(number)[0] if filled else "none"
        if body.fill == OPEN:
            style |= {"linewidth": 0.8, "linestyle": (0, (3, 2))}
    else:
        style = {"facecolor": body.fill, "edgecolor": body.edge, "linewidth": 1.0, "zorder": 1}
    still = bool(np.all(np.ptp(points, axis=0) < 1e-9))
    outline = silhouette(points[0], body.radii)
    patch = Polygon(outline, closed=True, joinstyle="round", animated=not still, **style)
    axis.add_patch(patch)

    def update(k: int) -> None:
        if not still:
            patch.set_xy(silhouette(points[k], body.radii))

    return update


def _rams(axis: "Axes", drawing: Drawing, motion: DrawnMotion, number: int) -> Update:
    ends = seen(motion, "side", places(motion, [spot for ram in drawing.rams for spot in (ram.base, ram.rod)]))
    style: dict[str, Any] = {"animated": True, "color": _edge(number), "zorder": _layer(number)}
    rods = [axis.plot([], [], linewidth=2.0, **style)[0] for _ in drawing.rams]
    broad = 1.3 if number else 6.5
    barrels = [axis.plot([], [], linewidth=broad, solid_capstyle="butt", **style)[0] for _ in drawing.rams]

    def update(k: int) -> None:
        for place, (ram, rod, barrel) in enumerate(zip(drawing.rams, rods, barrels, strict=True)):
            base, pin = ends[k, 2 * place : 2 * place + 2]
            rod.set_data(*np.array([base, pin]).T)
            end = base + (pin - base) * ram.barrel / np.linalg.norm(pin - base)
            barrel.set_data(*np.array([base, end]).T)

    return update


def _pins(axis: "Axes", drawing: Drawing, motion: DrawnMotion, number: int) -> Update:
    points = seen(motion, "side", places(motion, list(drawing.pins.values())))
    style: dict[str, Any] = {
        "color": "white",
        "markeredgecolor": _edge(number),
        "markersize": 4.0,
        "zorder": _layer(number) + 1,
    }
    (pins,) = axis.plot([], [], "o", animated=True, **style)
    return lambda k: pins.set_data(*points[k].T)


def _trails(axis: "Axes", motions: Sequence[DrawnMotion], effector: Sequence[np.ndarray], view: View) -> Update:
    paths = [seen(motion, view, tip[:, None, :])[:, 0] for motion, tip in zip(motions, effector, strict=True)]
    lines = [
        axis.plot([], [], animated=True, color=_edge(number), linewidth=0.9, alpha=0.6, zorder=2)[0]
        for number in range(len(motions))
    ]

    def update(k: int) -> None:
        for line, path in zip(lines, paths, strict=True):
            line.set_data(*path[: k + 1].T)

    return update


def _stops(axis: "Axes", drawing: Drawing, view: View, motion: DrawnMotion) -> Update:
    """Lines of travel with a tick at each end stop; a tick turns red while the run stands at its stop."""
    stops = [s for s in drawing.stops if s.view == view]
    paths = [seen(motion, view, places(motion, s.path)) for s in stops]
    ticks = [[seen(motion, view, places(motion, tick)) for tick in s.ticks] for s in stops]
    arcs = [axis.plot([], [], animated=True, color="0.55", linewidth=0.8, linestyle=":", zorder=6)[0] for _ in stops]
    marks = [[axis.plot([], [], animated=True, linewidth=2.4, zorder=6)[0] for _ in range(2)] for _ in stops]

    def update(k: int) -> None:
        for stop, path, pair, arc, both in zip(stops, paths, ticks, arcs, marks, strict=True):
            arc.set_data(*path[k].T)
            position = motion.positions[k, stop.joint]
            for tick, mark, end in zip(pair, both, (stop.low, stop.high), strict=True):
                mark.set_data(*tick[k].T)
                mark.set_color(STOP if abs(position - end) <= AT_STOP else "0.55")

    return update


def _strips(figure: "Figure", frames: Frames, shown: Sequence[PlottedChannel], in_a_row: int) -> list[Update]:
    """Quantities over time in rows at the bottom; titles as large as their places allow."""
    rows, width, height = ceil(len(shown) / in_a_row), 0.97 / in_a_row, figure.get_figheight()
    longest = max(len(_titled(channel, 0)) for channel in shown) + 2
    size = min(8.5, 72.0 * 9.6 * (width - 0.02) / (0.54 * longest))
    updates = []
    for place, channel in enumerate(shown):
        row, column = divmod(place, in_a_row)
        bottom = 0.434 + 1.2 * (rows - 1 - row)
        axis = figure.add_axes((0.055 + width * column, bottom / height, width - 0.055, 0.868 / height))
        updates.append(_strip(axis, frames, channel, size, last=row == rows - 1))
    return updates


def _titled(channel: PlottedChannel, k: int) -> str:
    """A channel with its value in the first run, or in the last where that is zero."""
    group = "" if channel.group.startswith("pumps") else f"{channel.group} "
    value = channel.values[-1 if channel.title == "tip from first" else 0][k]
    return f"{group}{channel.title}  {value:.{1 if abs(value) >= 10.0 else 2}f} {channel.unit}"


def _strip(axis: "Axes", frames: Frames, channel: PlottedChannel, size: float, *, last: bool) -> Update:
    """One quantity over time with a cursor, and its value as title."""
    apart = channel.title == "tip from first"
    for number, values in enumerate(channel.values):
        color, width = line_style(number, len(frames.names))
        if not (apart and number == 0):
            axis.plot(frames.time, values, color=color, linewidth=width)
    axis.set_xlim(frames.time[0], max(frames.time[-1], frames.time[0] + 1e-9))
    axis.tick_params(labelsize=7, labelbottom=last)
    axis.grid(alpha=0.3)
    if last:
        axis.set_xlabel("time [s]", fontsize=7, labelpad=1.0)
    cursor = axis.axvline(0.0, color=INK, linewidth=1.0, animated=True)
    title = axis.set_title("", fontsize=size, loc="left", pad=3.0, animated=True)

    def update(k: int) -> None:
        cursor.set_xdata([frames.time[k]] * 2)
        title.set_text(_titled(channel, k))

    return update
