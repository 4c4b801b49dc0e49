"""Pictures of runs: `run_figure` (the standard plot), `shapes` (the linkage as drawn), `frames`, `scene`, `gif` and `animation` (pages)."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
