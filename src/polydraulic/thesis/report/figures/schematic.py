"""Drawing of the series circuit: pump, two open-centre valves, actuators, tank (Fig 5-1)."""

from typing import TYPE_CHECKING

from polydraulic.thesis.report.figures.draw import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINE = {"color": "0.2", "linewidth": 1.4}


def draw_schematic() -> "Figure":
    """Draw the circuit from the pump on the left to the tank on the right."""
    figure, axes = canvas(1, 1, width=9.0, height=3.4)
    axis = axes[0, 0]
    _box(axis, 0.0, 0.0, "pump", round_=True)
    _arrow(axis, (0.55, 0.0), (1.95, 0.0), "Q, P")
    for x, number, link in ((2.6, 1, "swing"), (6.0, 2, "stick")):
        _box(axis, x, 0.0, f"{link} valve\nx_{link[:2]}")
        _box(axis, x, 1.9, f"{link}\n{'motor' if number == 1 else 'cylinder'}", round_=number == 1)
        _arrow(axis, (x - 0.3, 0.4), (x - 0.3, 1.5), f"Q_i{number}, P_i{number}", left=True)
        _arrow(axis, (x + 0.3, 1.5), (x + 0.3, 0.4), f"Q_o{number}, P_o{number}")
        _arrow(axis, (x, -0.4), (x, -1.15), "")
    _arrow(axis, (3.25, 0.0), (5.35, 0.0), "Q_e1 = Q_12, $\\bar{P}$")
    _arrow(axis, (6.65, 0.0), (8.2, 0.0), "Q_e2")
    axis.plot([2.6, 8.6], [-1.2, -1.2], **_LINE)
    axis.plot([8.6, 8.6], [-1.2, -0.35], **_LINE)
    _box(axis, 8.6, 0.0, "tank\nP_e")
    axis.set_xlim(-0.8, 9.4)
    axis.set_ylim(-1.5, 2.6)
    axis.set_axis_off()
    return figure


def _box(axis: "Axes", x: float, y: float, text: str, *, round_: bool = False) -> None:
    style = "circle,pad=0.35" if round_ else "square,pad=0.45"
    axis.text(x, y, text, ha="center", va="center", fontsize="small", bbox={"boxstyle": style, "fc": "#eef3f8", "ec": "0.2"})  # fmt: skip


def _arrow(
    axis: "Axes", start: tuple[float, float], end: tuple[float, float], text: str, *, left: bool = False
) -> None:
    axis.annotate("", end, start, arrowprops={"arrowstyle": "-|>", **_LINE})
    x, y = (start[0] + end[0]) / 2.0, (start[1] + end[1]) / 2.0
    upright = start[0] == end[0]
    side = "right" if left else "left"
    shift = (-0.1 if left else 0.1, 0.0) if upright else (0.0, 0.12)
    axis.text(x + shift[0], y + shift[1], text, ha=side if upright else "center", va="center" if upright else "bottom", fontsize="small")  # fmt: skip
