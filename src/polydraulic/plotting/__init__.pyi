from .animation import write_animation
from .machine_figure import draw_machine
from .run_figure import plot_run, save_figure

__all__ = [
    "draw_machine",
    "plot_run",
    "save_figure",
    "write_animation",
]
