"""Out of Python: models as C99, FMUs, ONNX, formulas, plain Python; the whole machine as C99 and FMU.

Read in this order: `model_bundle` (models that go together), `c`, `fmu`, `onnx`, `formula`, `targets` (all of them by name), `verify`
(the same points through all of them); `translate` (kernels as C), `machine` (the whole machine).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
