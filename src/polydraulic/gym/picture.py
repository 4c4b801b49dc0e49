"""A machine as a picture: side view and view from above, and where its tip should be."""

import numpy as np

from polydraulic.gym.workspace import Workspace
from polydraulic.plotting.drawing import View, motion_of, seen, view_limits
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.plotting.scene import draw_view, fill_place, moving_artists

_SIZE, _DPI = (6.4, 3.2), 100  # in
_GOAL = "#c0392b"
_POSES = 200  # that a picture has room for


def machine_picture(workspace: Workspace, position: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Draw a machine.

    Parameters
    ----------
    workspace : Workspace
    position : (n_function,) array, rad or m
    goal : (3,) array, m
        Along the ground's axes.

    Returns
    -------
    (height, width, 3) array of uint8
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawing = layout_drawing(workspace.machine)
    motion = motion_of(drawing, position[None])
    travels, n = workspace.travels, len(position)
    all_round = np.where(travels.turns, np.pi, 0.0)
    anywhere = np.random.default_rng(0).uniform(travels.low - all_round, travels.high + all_round, (_POSES, n))
    whole = motion_of(drawing, anywhere)
    figure = Figure(figsize=_SIZE, dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    views: list[tuple[View, float, float]] = [("side", 0.0, 0.6), ("top", 0.6, 0.4)]
    for view, left, width in views:
        axis = figure.add_axes((left, 0.0, width, 1.0))
        axis.axis("off")
        fill_place(axis, *view_limits(drawing, [whole], view))
        draw_view(axis, drawing, view, [motion])(0)
        place = seen(motion, view, goal[None, None])[0, 0]
        axis.plot(*place, "x", color=_GOAL, markersize=9.0, markeredgewidth=2.0, zorder=9)
    canvas.draw()
    for artist in moving_artists(figure):
        figure.draw_artist(artist)
    return np.array(np.asarray(canvas.buffer_rgba())[..., :3])
