"""The swappable subsystem: pump and main valves.

Read `interface` (what a model gives), `dispatch` (how one is chosen), then the models: `exact`, `iterative`, `stiff`
and `tlm`, which give pipes and passages a volume, `polynomial` (its finer networks, and neural, the same with perceptrons), `lookup`
(tables), and `pressure`, the historical attempt that fails.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
