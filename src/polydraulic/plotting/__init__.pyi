from .animation import write_animation
from .run_figure import plot_run, save_figure

__all__ = [
    "plot_run",
    "save_figure",
    "write_animation",
]
