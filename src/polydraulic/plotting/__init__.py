"""Pictures: `run_figure` (the standard plot), `machine_figure` (a machine standing still), `drawing` (what is drawn of one), `animation`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
