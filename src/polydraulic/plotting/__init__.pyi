from .animation import write_animation
from .load_chart_figure import draw_load_chart
from .machine_figure import draw_machine
from .run_figure import plot_run, save_figure

__all__ = [
    "draw_load_chart",
    "draw_machine",
    "plot_run",
    "save_figure",
    "write_animation",
]
