"""Animations of runs: a GIF, or a page that plays in any browser without a network."""

import json
from collections.abc import Mapping
from math import floor, log10
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.schema import Machine
from polydraulic.plotting.frames import Frames, frames_of
from polydraulic.plotting.gif import write_gif
from polydraulic.plotting.run_figure import line_style
from polydraulic.plotting.scene import FIRST_EDGE, views
from polydraulic.plotting.shapes import AT_STOP, GROUND, Shapes, linkage_shapes
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

# Frames a second. A GIF counts hundredths of a second; the page draws between its frames.
RATES = {".gif": 12.5, ".html": 20.0}
_TEMPLATE = Path(__file__).parent / "templates" / "animation.html"
_PLACE = "__ANIMATION__"


def write_animation(
    runs: Mapping[str, Table],
    machine: Machine | str | Path,
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
    machine : Machine, or name or path of a parameter set
        The machine that made them: its lengths, cylinders and end stops are drawn.
    path : str or Path
        Ends in ``.gif`` or ``.html``.
    rate : float, 1/s, optional
        Frames in a second of the run; `RATES` if not given.
    units : str
        Of what is shown: ``"metric"``, ``"field"`` or ``"si"``.
    progress : Progress, optional
        Told how many frames are drawn.

    Raises
    ------
    InputError
        Another ending, no run, a table that is no trajectory, a rate that is not positive, a place that cannot be written.
    """
    ending = animation_ending(path)
    shapes = linkage_shapes(as_machine(machine))
    frames = frames_of(runs, RATES[ending] if rate is None else rate, units)
    if ending == ".gif":
        write_gif(frames, shapes, path, progress)
    else:
        page = _TEMPLATE.read_text(encoding="utf-8")
        write_text(path, page.replace(_PLACE, _script_text(page_data(frames, shapes)), 1))
        progress("frames", len(frames.time), len(frames.time))


def animation_ending(path: str | Path) -> str:
    """Ending of an animation's path, or an InputError."""
    ending = Path(path).suffix.lower()
    if ending not in RATES:
        raise InputError(f"{path}: an animation ends in one of {sorted(RATES)}, not in {ending!r}")
    return ending


def page_data(frames: Frames, shapes: Shapes) -> dict[str, Any]:
    """All that the page shows, as plain lists, rounded to what a screen can show."""
    side, top = views(frames, shapes)
    return {
        "title": frames.title,
        "rate": frames.rate,
        "frames": len(frames.time),
        "ground": GROUND,
        "at_stop": AT_STOP,
        "view": {"side": _rounded(np.ravel(side), 3), "top": _rounded(np.ravel(top), 3)},
        "shapes": shapes._asdict() | {"boom_ram": shapes.boom_ram._asdict(), "stick_ram": shapes.stick_ram._asdict()},
        "runs": [
            {
                "name": name,
                "color": line_style(number)[0],
                "edge": FIRST_EDGE if number == 0 else line_style(number)[0],
                "angles": _rounded(frames.angles[number], 5),
                "effector": _rounded(frames.effector[number], 4),
                "in_plane": _rounded(frames.in_plane[number], 4),
            }
            for number, name in enumerate(frames.names)
        ],
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


def _rounded(values: Any, digits: int) -> Any:
    return (np.round(values, digits) + 0.0).tolist()


def _digits(values: list[np.ndarray]) -> int:
    """Decimals that show a ten-thousandth of the largest value."""
    largest = max(float(np.abs(v).max()) for v in values)
    return 2 if largest == 0.0 else max(0, 4 - floor(log10(largest)))


def _script_text(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
