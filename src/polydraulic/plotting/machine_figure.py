"""A machine as its file describes it, standing still: links, pins, cylinders and the travel of its joints, all with their names."""

from math import pi
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import DEFAULT, amount, as_shown, checked_units, shown_unit
from polydraulic.machine.frames import vector
from polydraulic.parameters.layout.chassis import Chassis
from polydraulic.parameters.layout.parts import GROUND
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine, machine_title
from polydraulic.plotting.drawing import (
    OPEN,
    Drawing,
    DrawnMotion,
    Spot,
    View,
    motion_of,
    places,
    seen,
    silhouette,
    view_limits,
)
from polydraulic.plotting.labels import Label, place_labels
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.plotting.scene import FIRST_EDGE, draw_view, fill_place, moving_artists
from polydraulic.plotting.tip_area import tip_area, tip_places

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_VIEWS: tuple[View, View] = ("side", "top")
_STANCE = "#1b7f5c"
_WIDE, _TALL, _FROM_ABOVE = (
    8.68,
    (6.3, 9.5),
    4.03,
)  # in: width of the side view, ends of its height, height of the view from above
_ABOVE, _BELOW = 0.61, 0.68  # in, of titles and of axes
_STANDING = "Triangles: where the chassis stands; cross: its centre of gravity."
_NOTE = "At its initial positions. Dotted: travel of joints, with their end stops; shaded: where the tip can be. Outlines and body are only illustrative."


def draw_machine(machine: LayoutMachine | str | Path, *, units: str = DEFAULT) -> "Figure":
    """Draw a machine with the names of its links, pins and cylinders: a look shows whether its file says what was meant.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    units : str
        Of lengths and ranges: ``"metric"``, ``"field"`` or ``"si"``.

    Returns
    -------
    matplotlib Figure
        Side view in the plane of the arm with all names, and the view from above.

    Raises
    ------
    InputError
        A machine that cannot be loaded, or an unknown system of units.
    """
    from matplotlib.figure import Figure

    checked_units(units)
    title = machine_title(machine) if isinstance(machine, str | Path) else machine.title
    machine = as_machine(machine)
    drawing = layout_drawing(machine)
    motion = motion_of(drawing, np.array([drawing.initial]))
    reached = tip_places(drawing)
    stands = {view: _stance(machine.chassis, motion, view) for view in _VIEWS}
    others = {"side": np.vstack([reached, stands["side"]]), "top": stands["top"]}
    limits = {view: _limits(drawing, motion, view, others[view]) for view in _VIEWS}
    width, height = limits["side"][1] - limits["side"][0]
    tall = float(
        np.clip(_WIDE * height / width, *_TALL)
    )  # in, as the machine is: what is drawn larger has room for names
    figure = Figure(figsize=(14.0, tall + _ABOVE + _BELOW), dpi=100)

    def up(inches: float) -> float:
        """From a distance to the upper edge, in, to a share of the figure's height."""
        return 1.0 - inches / (tall + _ABOVE + _BELOW)

    side = figure.add_axes((0.055, up(_ABOVE + tall), _WIDE / 14.0, tall / (tall + _ABOVE + _BELOW)))
    top = figure.add_axes((0.735, up(_ABOVE + _FROM_ABOVE), 0.255, _FROM_ABOVE / (tall + _ABOVE + _BELOW)))
    fill_place(side, *limits["side"])
    fill_place(top, *limits["top"])
    x, y, area = tip_area(reached)
    side.contourf(x, y, area, levels=[0.5, 2.0], colors=["#f6c98f"], alpha=0.35, zorder=0.5)
    for axis, view in zip((side, top), _VIEWS, strict=True):
        _still(axis, drawing, view, motion, units)
        if machine.chassis is not None:
            _support(axis, view, stands[view])
    _name(side, drawing, motion, units)
    figure.text(0.02, up(0.34), title, fontweight="bold", fontsize=12)
    figure.text(
        0.02,
        0.14 / (tall + _ABOVE + _BELOW),
        _NOTE if machine.chassis is None else f"{_NOTE} {_STANDING}",
        fontsize=8.5,
        color="0.4",
    )
    indent = 0.012 + 0.0062 * max(len(name) for name in drawing.names)
    ranges = []
    for place, (name, text) in enumerate(_ranges(drawing, units)):
        row = up(_ABOVE + _FROM_ABOVE + 0.72 + 0.182 * place)
        figure.text(0.715, row, name, fontsize=8.5, fontweight="bold", color=FIRST_EDGE)
        ranges.append(figure.text(0.715 + indent, row, text, fontsize=8.5))
    left = 0.715 + indent
    right = max(shown.get_window_extent().x1 for shown in ranges) / figure.bbox.width
    for shown in ranges:
        shown.set_fontsize(8.5 * min(1.0, (0.99 - left) / (right - left)))  # none runs off the page
    return figure


def _still(axis: "Axes", drawing: Drawing, view: View, motion: DrawnMotion, units: str) -> None:
    from matplotlib.ticker import MaxNLocator

    draw_view(axis, drawing, view, [motion])(0)
    for artist in moving_artists(axis.figure):  # type: ignore[arg-type]
        artist.set_animated(False)
    unit = shown_unit("m", units)
    names = ("outward", "upward") if view == "side" else ("x", "y")
    for scale, ends in ((axis.xaxis, axis.get_xlim()), (axis.yaxis, axis.get_ylim())):
        ticks = MaxNLocator(7, steps=[1, 2, 5, 10]).tick_values(*(as_shown(end, "m", units) for end in ends))[1:-1]
        scale.set_ticks([tick / as_shown(1.0, "m", units) for tick in ticks], [f"{tick:g}" for tick in ticks])
    axis.set_xlabel(f"{names[0]} [{unit}]", fontsize=8)
    axis.set_ylabel(f"{names[1]} [{unit}]", fontsize=8)
    axis.tick_params(labelsize=8)
    axis.grid(alpha=0.25)
    axis.set_axisbelow(True)
    title = "side view, in the plane of the arm" if view == "side" else "from above"
    axis.set_title(title, loc="left", fontsize=9, color="0.4")


def _limits(drawing: Drawing, motion: DrawnMotion, view: View, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of a view of the machine that has other places in it, too, of shape (n, 2)."""
    low, high = view_limits(drawing, [motion], view)
    margin = 0.04 * (high - low).max()
    ends = others.min(axis=0, initial=np.inf) - margin, others.max(axis=0, initial=-np.inf) + margin
    return np.minimum(low, ends[0]), np.maximum(high, ends[1])


def _stance(chassis: Chassis | None, motion: DrawnMotion, view: View) -> np.ndarray:
    """What it stands on, as a view shows it: contacts, and the centre of gravity of what no joint moves; of shape (n, 2)."""
    if chassis is None:
        return np.empty((0, 2))
    x, y, z = vector(chassis.cg)
    spots = [Spot(GROUND, corner) for corner in (*chassis.corners, (x, y, z))]
    return np.asarray(seen(motion, view, places(motion, spots))[0])


def _support(axis: "Axes", view: View, stands: np.ndarray) -> None:
    """Draw what it stands on, from above with the area between the contacts."""
    contacts, middle = stands[:-1], stands[-1]
    axis.plot(*contacts.T, "^", color=_STANCE, markersize=7, zorder=6)
    axis.plot(*middle, "P", color=_STANCE, markersize=8, markeredgecolor="white", zorder=6)
    if view == "top":
        axis.plot(*np.vstack([contacts, contacts[:1]]).T, "--", color=_STANCE, linewidth=1.2, zorder=5)


def _name(axis: "Axes", drawing: Drawing, motion: DrawnMotion, units: str) -> None:
    """Names of pins, links and cylinders, and ranges of joints."""

    def shown(spot: Spot) -> tuple[float, float]:
        x, y = seen(motion, "side", places(motion, [spot]))[0, 0]
        return float(x), float(y)

    bodies = [body for body in drawing.bodies if "side" in body.views]
    outlines = [silhouette(seen(motion, "side", places(motion, body.spots))[0], body.radii) for body in bodies]
    pins = [Label(name, shown(spot), {"fontsize": 8.0, "color": "0.15"}) for name, spot in drawing.pins.items()]
    links: list[Label] = []
    ends: list[Label] = []
    moved = {link.name for link in drawing.links[: len(drawing.names)]}
    for body, outline in zip(bodies, outlines, strict=True):
        name = body.spots[0].link
        if name in moved and body.fill != OPEN and name not in {label.text for label in links}:
            middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
            links.append(
                Label(
                    name,
                    (float(middle[0]), float(middle[1])),
                    {"fontsize": 10.0, "color": FIRST_EDGE, "fontweight": "bold"},
                )
            )
    for stop in drawing.stops:
        unit = "m" if drawing.links[stop.joint].joint == "prismatic" else "rad"
        if stop.view == "side":
            for value, tick in zip((stop.low, stop.high), stop.ticks, strict=True):
                ends.append(Label(amount(value, unit, units), shown(tick[1]), {"fontsize": 7.0, "color": "0.45"}))
    lines = [np.array([shown(ram.base), shown(ram.rod)]) for ram in drawing.rams]
    for stop in (stop for stop in drawing.stops if stop.view == "side"):
        lines += [np.array([shown(spot) for spot in line]) for line in (stop.path, *stop.ticks)]
    place_labels(axis, [*pins, *ends, *links], outlines, lines)


def _ranges(drawing: Drawing, units: str) -> list[tuple[str, str]]:
    """What each function moves, from where to where, and where it begins."""
    rows = []
    for place, (name, start) in enumerate(zip(drawing.names, drawing.initial, strict=True)):
        link, (low, high) = drawing.links[place], drawing.travel[place]
        unit = "m" if link.joint == "prismatic" else "rad"
        travel = f"{amount(low, unit, units)} to {amount(high, unit, units)}"
        travel = "all round" if unit == "rad" and high - low > 4.0 * pi else travel
        moves = "" if link.name == name else f"moves {link.name}, "
        rows.append((name, f"{moves}{travel}, begins at {amount(start, unit, units)}"))
    return rows
