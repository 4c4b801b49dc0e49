"""Animations of runs: a GIF, or a page that plays in any browser without a network."""

import json
from collections.abc import Mapping, Sequence
from math import floor, log10
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.machine.frames import vector
from polydraulic.parameters.layout.parts import GROUND, LinkParameters
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.plotting.drawing import AT_STOP, PLANE, Drawing, DrawnMotion, Spot, motion_of, view_limits
from polydraulic.plotting.frames import Frames, frames_of
from polydraulic.plotting.gif import write_gif
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.plotting.run_figure import line_style
from polydraulic.plotting.scene import CAPTIONS, FIRST_EDGE
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

# Frames a second. A GIF counts hundredths of a second; the page draws between its frames.
RATES = {".gif": 12.5, ".html": 20.0}
_TEMPLATE = Path(__file__).parent / "templates" / "animation.html"
_PLACE = "__ANIMATION__"


def write_animation(
    runs: Mapping[str, Table],
    machine: LayoutMachine | str | Path,
    path: str | Path,
    *,
    rate: float | None = None,
    units: str = DEFAULT,
    progress: Progress = quiet,
) -> None:
    """Write an animation of one run or of several on top of each other, whole or not at all.

    The first run is drawn filled, the others as outlines; distances of the end-effector are from the first.

    Parameters
    ----------
    runs : mapping from label to trajectory
        From `simulate`; the animation lasts as long as the shortest.
    machine : LayoutMachine, or name or path of a parameter set
        The machine that made them: its links, cylinders and end stops are drawn.
    path : str or Path
        Ends in ``.gif`` or ``.html``.
    rate : float, 1/s, optional
        Frames per second of the run; `RATES` if not given.
    units : str
        Of what is shown: ``"metric"``, ``"field"`` or ``"si"``.
    progress : Progress, optional
        Told how many frames are drawn.

    Raises
    ------
    InputError
        Another ending, no run, a table that is not a trajectory of this machine, a rate that is not positive, a place that cannot be written.
    """
    ending = animation_ending(path)
    drawing = layout_drawing(as_machine(machine))
    frames = frames_of(runs, drawing.names, RATES[ending] if rate is None else rate, units)
    if ending == ".gif":
        write_gif(frames, drawing, path, progress)
    else:
        page = _TEMPLATE.read_text(encoding="utf-8")
        write_text(path, page.replace(_PLACE, _script_text(page_data(frames, drawing)), 1))
        progress("frames", len(frames.time), len(frames.time))


def animation_ending(path: str | Path) -> str:
    """Ending of an animation's path, or an InputError."""
    ending = Path(path).suffix.lower()
    if ending not in RATES:
        raise InputError(f"{path}: an animation ends in one of {sorted(RATES)}, not in {ending!r}")
    return ending


def page_data(frames: Frames, drawing: Drawing) -> dict[str, Any]:
    """All that the page shows, as plain lists, rounded to what a screen can show."""
    motions = [motion_of(drawing, positions) for positions in frames.positions]
    places = {PLANE: -2, GROUND: -1} | {link.name: place for place, link in enumerate(drawing.links)}

    def spots(several: Sequence[Spot]) -> list[list[float]]:
        return [[places[link], *_rounded(at, 4)] for link, at in several]

    return {
        "title": frames.title,
        "rate": frames.rate,
        "frames": len(frames.time),
        "ground": drawing.ground,
        "scale": drawing.scale,
        "at_stop": AT_STOP,
        "captions": CAPTIONS,
        "view": {view: _rounded(np.ravel(view_limits(drawing, motions, view)), 3) for view in drawing.corners},
        "slews": drawing.slews,
        "links": [_joint(link, places) for link in drawing.links],
        "bodies": [
            {"spots": spots(b.spots), "radii": _rounded(b.radii, 4), "views": b.views, "fill": b.fill, "edge": b.edge}
            for b in drawing.bodies
        ],
        "rams": [{"ends": spots((ram.base, ram.rod)), "barrel": ram.barrel} for ram in drawing.rams],
        "pins": spots(list(drawing.pins.values())),
        "stops": [
            s._asdict() | {"path": spots(s.path), "ticks": [spots(tick) for tick in s.ticks]} for s in drawing.stops
        ],
        "runs": [_run(frames, motion, number) for number, motion in enumerate(motions)],
        "channels": [
            {
                "group": c.group,
                "title": c.title,
                "unit": c.unit,
                "values": [_rounded(v, _digits(c.values)) for v in c.values],
            }
            for c in frames.channels
        ],
    }


def _joint(link: LinkParameters, places: Mapping[str, int]) -> dict[str, Any]:
    return {
        "parent": places[link.parent],
        "slides": link.joint == "prismatic",
        "axis": "xyz".index(link.axis[-1]),
        "sign": -1 if link.axis[0] == "-" else 1,
        "at": _rounded(vector(link.at), 4),
    }


def _run(frames: Frames, motion: DrawnMotion, number: int) -> dict[str, Any]:
    color = line_style(number)[0]
    return {
        "name": frames.names[number],
        "color": color,
        "edge": color if number else FIRST_EDGE,
        "positions": _rounded(motion.positions, 5),
        "effector": _rounded(frames.effector[number], 4),
    }


def _rounded(values: Any, digits: int) -> Any:
    return (np.round(values, digits) + 0.0).tolist()


def _digits(values: list[np.ndarray]) -> int:
    """Decimals that show a ten-thousandth of the largest value."""
    largest = max(float(np.abs(v).max()) for v in values)
    return 2 if largest == 0.0 else max(0, 4 - floor(log10(largest)))


def _script_text(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
