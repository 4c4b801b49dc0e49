"""The linkage as matplotlib draws it: side view, view from above, and joint angles over time.

Artists that change from frame to frame are marked as animated, so that a writer can draw the others once.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.plotting.frames import Frames, PlottedChannel
from polydraulic.plotting.run_figure import line_style
from polydraulic.plotting.shapes import AT_STOP, GROUND, Points, Ram, Shapes, placed, pose, seen_from_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DARK, FIRST_EDGE, BODY, TRACK, STOP = "#34495e", "#3b6ea5", "#e3e6ea", "#c9ced6", "#c0392b"
Update = Callable[[int], None]


def moving_artists(figure: "Figure") -> list[Any]:
    """Artists that change from frame to frame, lowest first."""
    return sorted(figure.findobj(lambda artist: artist.get_animated()), key=lambda artist: artist.get_zorder())


def scene(frames: Frames, shapes: Shapes) -> tuple["Figure", Update]:
    """Return a scene without moving parts, and the function that puts them where they are in a frame."""
    from matplotlib.figure import Figure

    shown = [c for c in frames.channels if c.title in ("angle", "tip height", "tip from first")]
    shown = shown[:-2] + shown[-1:] if len(frames.names) > 1 else shown
    figure = Figure(figsize=(9.6, 6.2))
    side = figure.add_axes((0.01, 0.27, 0.6, 0.67))
    top = figure.add_axes((0.62, 0.27, 0.37, 0.67))
    width = 0.97 / len(shown)
    strips = [figure.add_axes((0.055 + width * i, 0.07, width - 0.055, 0.14)) for i in range(len(shown))]
    updates = [_side_view(side, frames, shapes), _top_view(top, frames, shapes)]
    updates += [_strip(axis, frames, channel) for axis, channel in zip(strips, shown, strict=True)]
    clock = figure.text(0.985, 0.957, "", ha="right", family="monospace", fontsize=11, animated=True)
    figure.text(0.015, 0.957, frames.title, fontweight="bold", fontsize=11)
    for number, name in enumerate(frames.names):
        color = FIRST_EDGE if number == 0 else line_style(number)[0]
        figure.text(0.25 + 0.14 * number, 0.957, f"\u25a0 {name}", color=color, fontsize=10)

    def update(k: int) -> None:
        clock.set_text(f"{frames.time[k]:6.2f} s")
        for part in updates:
            part(k)

    return figure, update


def _frameless(axis: "Axes", low: np.ndarray, high: np.ndarray, title: str) -> None:
    """Equal scales, a bar of 1 m, no frame; the view is widened to fill its place, a little more to the upper right."""
    width, height = axis.get_window_extent().size
    scale = max((high - low) / (width, height))
    spare = scale * np.array([width, height]) - (high - low)
    low, high = low - 0.4 * spare, high + 0.6 * spare
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    axis.axis("off")
    bar = low + scale * np.array([14.0, 12.0])
    axis.plot([bar[0], bar[0] + 1.0], [bar[1]] * 2, color=DARK, linewidth=2.0)
    axis.text(bar[0] + 0.5, bar[1] + 4.0 * scale, "1 m", ha="center", va="bottom", fontsize=8, color=DARK)
    axis.text(0.02, 0.98, title, transform=axis.transAxes, va="top", fontsize=8.5, color="0.45")


def _polygon(axis: "Axes", points: Any, **style: Any) -> Any:
    from matplotlib.patches import Polygon

    return axis.add_patch(Polygon(points, closed=True, joinstyle="round", **style))


def views(frames: Frames, shapes: Shapes) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Lower and upper corners of side view and top view, m: the machine and all places that tips reach."""
    outward, height = np.concatenate(frames.in_plane).T
    joint = max(shapes.boom_length * float(np.sin(a[:, 1]).max()) for a in frames.angles)
    side = (
        np.array([-3.1, min(GROUND - 0.75, float(height.min()) - 1.1)]),
        np.array([max(4.0, float(outward.max()) + 1.0), max(1.7, joint + 0.9, float(height.max()) + 1.2)]),
    )
    across = np.concatenate([e[:, :2] for e in frames.effector])
    low, high = np.minimum(across.min(axis=0) - 0.8, -3.1), np.maximum(across.max(axis=0) + 0.8, 3.1)
    return side, (low, high)


def _side_view(axis: "Axes", frames: Frames, shapes: Shapes) -> Update:
    (low, high), _ = views(frames, shapes)
    _frameless(axis, low, high, "side view, in the plane of the boom; ticks are end stops, red when reached")
    axis.axhspan(axis.get_ylim()[0], GROUND, color="#f3efe8", linewidth=0.0, zorder=0)
    axis.axhline(GROUND, color="#b8ad9a", linewidth=1.0, zorder=0)
    _polygon(axis, shapes.track, facecolor=TRACK, edgecolor=DARK, linewidth=1.0)
    axis.plot([0.0, 0.0], [GROUND + 0.78, -0.72], color=DARK, linewidth=14.0, solid_capstyle="butt")
    _polygon(axis, shapes.upper, facecolor=BODY, edgecolor=DARK, linewidth=1.0)
    _polygon(axis, shapes.cab, facecolor="#f4f6f8", edgecolor=DARK, linewidth=1.0)
    _polygon(axis, shapes.window, facecolor="#d5e6f3", edgecolor="none")
    updates = [_stops(axis, frames, shapes)]
    updates += [_machine(axis, frames, shapes, number) for number in reversed(range(len(frames.names)))]

    def update(k: int) -> None:
        for part in updates:
            part(k)

    return update


def _machine(axis: "Axes", frames: Frames, shapes: Shapes, number: int) -> Update:
    """Boom, stick and cylinders of one run: the first filled, the others as outlines."""
    color = line_style(number)[0]
    style: dict[str, Any] = {"facecolor": color, "edgecolor": FIRST_EDGE, "linewidth": 1.2, "zorder": 3}
    if number:
        style = {"facecolor": "none", "edgecolor": color, "linewidth": 1.3, "zorder": 5}
    ghost = style | {"facecolor": "none", "linewidth": 0.8, "linestyle": (0, (3, 2))}
    parts = [_polygon(axis, [(0.0, 0.0)], animated=True, **s) for s in (ghost, style, style)]
    edge = style["edgecolor"]
    rods = [axis.plot([], [], animated=True, color=edge, linewidth=2.0, zorder=style["zorder"])[0] for _ in range(2)]
    barrels = [
        axis.plot(
            [],
            [],
            animated=True,
            color=edge,
            linewidth=1.3 if number else 6.5,
            solid_capstyle="butt",
            zorder=style["zorder"],
        )[0]
        for _ in range(2)
    ]
    (pins,) = axis.plot(
        [], [], "o", animated=True, color="white", markeredgecolor=edge, markersize=4.0, zorder=style["zorder"] + 1
    )
    (trail,) = axis.plot([], [], animated=True, color=edge, linewidth=0.9, alpha=0.6, zorder=2)
    angles, tip = frames.angles[number], frames.in_plane[number]

    def update(k: int) -> None:
        boom, stick = angles[k, 1], angles[k, 2]
        at = pose(shapes, boom, stick)
        parts[0].set_xy(placed(shapes.bucket, at.joint, boom + stick))
        parts[1].set_xy(placed(shapes.stick, at.joint, boom + stick))
        parts[2].set_xy(placed(shapes.boom, at.foot, boom))
        pairs = ((shapes.boom_ram, at.boom_base, at.boom_rod), (shapes.stick_ram, at.stick_base, at.stick_rod))
        for rod, barrel, pair in zip(rods, barrels, pairs, strict=True):
            _ram(rod, barrel, *pair)
        pins.set_data(*np.array(at).T)
        trail.set_data(tip[: k + 1, 0], tip[: k + 1, 1])

    return update


def _ram(rod: Any, barrel: Any, ram: Ram, base: np.ndarray, pin: np.ndarray) -> None:
    end = base + (pin - base) * ram.barrel / np.linalg.norm(pin - base)
    rod.set_data(*np.array([base, pin]).T)
    barrel.set_data(*np.array([base, end]).T)


def _stops(axis: "Axes", frames: Frames, shapes: Shapes) -> Update:
    """Arcs of travel with a tick at each end stop; a tick turns red while the first run stands at its stop."""
    rows = [(i, link, r) for i, link, r in ((1, "boom", 1.25), (2, "stick", 0.95)) if link in shapes.stops]
    arcs = [axis.plot([], [], animated=True, color="0.55", linewidth=0.8, linestyle=":", zorder=6)[0] for _ in rows]
    ticks = [[axis.plot([], [], animated=True, linewidth=2.4, zorder=6)[0] for _ in range(2)] for _ in rows]

    def update(k: int) -> None:
        angles = frames.angles[0][k]
        at = pose(shapes, angles[1], angles[2])
        for (place, link, radius), arc, pair in zip(rows, arcs, ticks, strict=True):
            centre, turned = (at.foot, 0.0) if link == "boom" else (at.joint, angles[1])
            ends = shapes.stops[link]
            sweep = turned + np.linspace(*ends, 40)
            arc.set_data(*(centre + radius * np.column_stack([np.cos(sweep), np.sin(sweep)])).T)
            for tick, end in zip(pair, ends, strict=True):
                direction = np.array([np.cos(turned + end), np.sin(turned + end)])
                tick.set_data(*np.array([centre + 0.88 * radius * direction, centre + 1.12 * radius * direction]).T)
                tick.set_color(STOP if abs(angles[place] - end) <= AT_STOP else "0.55")

    return update


def _top_view(axis: "Axes", frames: Frames, shapes: Shapes) -> Update:
    _, (low, high) = views(frames, shapes)
    _frameless(axis, low, high, "from above")
    for track in shapes.tracks_top:
        _polygon(axis, track, facecolor=TRACK, edgecolor=DARK, linewidth=1.0)
    body = _polygon(axis, [(0.0, 0.0)], animated=True, facecolor=BODY, edgecolor=DARK, linewidth=1.0)
    cab = _polygon(axis, [(0.0, 0.0)], animated=True, facecolor="#d5e6f3", edgecolor=DARK, linewidth=0.8)
    order = list(reversed(range(len(frames.names))))
    drawn = [_arm_from_above(axis, frames, shapes, number) for number in order]

    def update(k: int) -> None:
        swing = frames.angles[0][k, 0]
        body.set_xy(placed(shapes.upper_top, np.zeros(2), swing))
        cab.set_xy(placed(shapes.cab_top, np.zeros(2), swing))
        for part in drawn:
            part(k)

    return update


def _arm_from_above(axis: "Axes", frames: Frames, shapes: Shapes, number: int) -> Update:
    color = line_style(number)[0]
    edge = color if number else FIRST_EDGE
    fill, layer = ("none", 5) if number else (color, 3)
    parts = [
        _polygon(axis, [(0.0, 0.0)], animated=True, facecolor=fill, edgecolor=edge, linewidth=1.2, zorder=layer)
        for _ in range(2)
    ]
    (trail,) = axis.plot([], [], animated=True, color=edge, linewidth=0.9, alpha=0.6, zorder=2)
    angles, effector = frames.angles[number], frames.effector[number]

    def update(k: int) -> None:
        swing, boom, stick = angles[k]
        joint = shapes.a1 + shapes.boom_length * np.cos(boom)
        tip = joint + shapes.stick_length * np.cos(boom + stick)
        outlines: tuple[Points, Points] = (
            seen_from_above(shapes, tip, joint, 0.17),
            seen_from_above(shapes, joint, shapes.a1, 0.24),
        )
        for part, outline in zip(parts, outlines, strict=True):
            part.set_xy(placed(outline, np.zeros(2), swing))
        trail.set_data(effector[: k + 1, 0], effector[: k + 1, 1])

    return update


def _strip(axis: "Axes", frames: Frames, channel: PlottedChannel) -> Update:
    """One quantity over time with a cursor; the title gives its value in the first run, or in the last where that is zero."""
    apart = channel.title == "tip from first"
    for number, values in enumerate(channel.values):
        color, width = line_style(number)
        if not (apart and number == 0):
            axis.plot(frames.time, values, color=color, linewidth=width)
    axis.set_xlim(frames.time[0], max(frames.time[-1], frames.time[0] + 1e-9))
    axis.tick_params(labelsize=7)
    axis.grid(alpha=0.3)
    axis.set_xlabel("time [s]", fontsize=7, labelpad=1.0)
    cursor = axis.axvline(0.0, color=DARK, linewidth=1.0, animated=True)
    group = "" if channel.group.startswith("pumps") else f"{channel.group} "
    title = axis.set_title("", fontsize=8.5, loc="left", pad=3.0, animated=True)
    shown = channel.values[-1 if apart else 0]

    def update(k: int) -> None:
        cursor.set_xdata([frames.time[k]] * 2)
        title.set_text(f"{group}{channel.title}  {shown[k]:.{1 if abs(shown[k]) >= 10.0 else 2}f} {channel.unit}")

    return update
