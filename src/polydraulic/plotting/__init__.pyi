from .animation import write_animation
from .run_figure import plot_run

__all__ = [
    "plot_run",
    "write_animation",
]
