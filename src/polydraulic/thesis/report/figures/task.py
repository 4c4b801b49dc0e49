"""The task as it looks: the linkage at the ends of its phases, and the paths of the end-effector with each flow model."""

from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.plotting.drawing import OF_RUN, OPEN, View, motion_of, places, seen, silhouette
from polydraulic.plotting.drawing import Drawing as Linkage
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Figure
from polydraulic.thesis.report.differences import phases
from polydraulic.thesis.report.figures.draw import STYLES, canvas, line, name_of
from polydraulic.thesis.three_links import three_link_study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_KINDS = ("exact", "polynomial", "ours")
_LINK: dict[str, Any] = {"facecolor": "0.88", "edgecolor": "0.45", "linewidth": 0.8}
_REST: dict[str, Any] = {"facecolor": "0.95", "edgecolor": "0.6", "linewidth": 0.8}
_NEAR = 0.9  # m; poses whose tips are closer share one label


def task_picture(lab: Lab) -> Figure:
    """Side view and view from above."""
    runs = three_link_study(lab).runs("task", *_KINDS)
    exact, machine = runs["exact"], lab.machine
    times = [0.0, *(end for _, end in phases("task", "boom"))]
    angles = exact.matrix([f"{link}.angle" for link in ("swing", "boom", "stick")])
    poses = {time: angles[min(int(np.searchsorted(exact["time"], time - 1e-9)), len(exact) - 1)] for time in times}
    columns = {"time": exact["time"]}
    for kind, run in runs.items():
        outward, height = _in_plane(machine, run)
        found = {"outward": outward, "height": height, "X": run["effector.x"], "Y": run["effector.y"]}
        columns |= {f"{name_of(kind)} {name}": values for name, values in found.items()}
    table = Table(columns, {"time": "s", **dict.fromkeys(list(columns)[1:], "m")})

    def draw() -> "Drawing":
        figure, axes = canvas(1, 2, width=9.6, height=3.7)
        linkage = layout_drawing(machine)
        axes[0, 0].axhline(linkage.ground, color="#b8ad9a", linewidth=1.0)
        _poses(axes[0, 0], linkage, poses, "side", np.array([0.2, 0.0]))
        _poses(axes[0, 1], linkage, poses, "top", np.array([0.2, 0.15]))
        for axis, title, across, up in (
            (
                axes[0, 0],
                "(a) in the plane of the boom",
                "distance from the swing axis [m]",
                "height above the boom joint [m]",
            ),
            (axes[0, 1], "(b) from above", "X [m]", "Y [m]"),
        ):
            axis.set_title(title, fontsize="medium")
            axis.set_xlabel(across)
            axis.set_ylabel(up)
        for axis, (across, up) in zip(axes[0], (("outward", "height"), ("X", "Y")), strict=True):
            for kind in _KINDS:
                name = name_of(kind)
                x, y = table[f"{name} {across}"], table[f"{name} {up}"]
                line(axis, kind, x, y)
                axis.plot(x[-1], y[-1], "o", color=STYLES[kind][0], markeredgecolor="k", markersize=7, zorder=7)
            axis.set_aspect("equal")
            axis.grid(alpha=0.3)
        axes[0, 1].legend(fontsize="small", loc="upper left", title="path of the end-effector", title_fontsize="small")
        return figure

    return Figure(
        "The task: linkage at the ends of its phases, and paths of the end-effector",
        "Grey: poses of the exact run. Dots: where the end-effector is at the end of each run; the distance between dots is the end-effector error.",
        {"": table},
        draw,
    )


def _in_plane(machine: LayoutMachine, run: Table) -> tuple[np.ndarray, np.ndarray]:
    """Distance of the tip from the swing axis and its height above the boom joint, in m."""
    foot, boom_length, stick_length = machine.link("boom").at["x"], machine.link("stick").at["x"], machine.tip[1]["x"]
    boom, both = run["boom.angle"], run["boom.angle"] + run["stick.angle"]
    outward = foot + boom_length * np.cos(boom) + stick_length * np.cos(both)
    return outward, boom_length * np.sin(boom) + stick_length * np.sin(both)


def _poses(axis: "Axes", linkage: Linkage, poses: dict[float, np.ndarray], view: View, shift: np.ndarray) -> None:
    """The machine at rest once, boom and stick in every pose, times beside the tips."""
    motion = motion_of(linkage, np.array([*poses.values()]))
    for body in linkage.bodies:
        if view not in body.views or body.fill == OPEN:
            continue
        corners = seen(motion, view, places(motion, body.spots))
        if body.fill != OF_RUN:
            _polygon(axis, silhouette(corners[0], body.radii), **_REST)
            continue
        for number, outline in enumerate(corners):
            _polygon(axis, silhouette(outline, body.radii), alpha=_opacity(number, len(poses)), **_LINK)
    tips = dict(zip(poses, seen(motion, view, places(motion, [linkage.tip]))[:, 0], strict=True))
    _label(axis, tips, shift)
    axis.set_xlim(-3.0, 2.1 + max(tip[0] for tip in tips.values()))


def _label(axis: "Axes", tips: dict[float, np.ndarray], shift: np.ndarray) -> None:
    """Times beside the tips; tips that lie close together share a label."""
    groups: list[tuple[np.ndarray, list[str]]] = []
    for time, tip in tips.items():
        for place, times in groups:
            if np.linalg.norm(tip - place) < _NEAR:
                times.append(f"{time:g}")
                break
        else:
            groups.append((tip, [f"{time:g}"]))
    for place, times in groups:
        x, y = place + shift
        axis.text(x, y, f"{', '.join(times)} s", fontsize="small", va="center", zorder=6)


def _opacity(number: int, of: int) -> float:
    """Later poses are more solid."""
    return 0.35 + 0.5 * (number + 1) / of


def _polygon(axis: "Axes", points: Any, **style: Any) -> None:
    from matplotlib.patches import Polygon

    axis.add_patch(Polygon(points, closed=True, joinstyle="round", **style))
