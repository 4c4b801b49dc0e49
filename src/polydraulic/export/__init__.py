"""Out of Python: models as C99, FMUs, ONNX, formulas, plain Python; the whole machine as C99 and FMU.

Read in this order: `bundle` (models that go together), `c` with `c_network` and `c_text`, `fmu`, `onnx`, `formula`, `targets`
(all of them by name), `verify` (the same points through all of them);
`translate` (kernels as C), `machine` (all of it).
"""

from polydraulic.export.bundle import Bundle, bundle, c_name
from polydraulic.export.c import export_c, to_c
from polydraulic.export.fmu import export_fmu, export_machine_fmu
from polydraulic.export.formula import to_latex, to_python, to_sympy, to_text
from polydraulic.export.machine import export_machine, machine_c
from polydraulic.export.onnx import export_onnx, to_onnx
from polydraulic.export.targets import TARGETS, Exported, export_models
from polydraulic.export.verify import Agreement, agreement_table, verify_models

__all__ = [
    "TARGETS",
    "Agreement",
    "Bundle",
    "Exported",
    "agreement_table",
    "bundle",
    "c_name",
    "export_c",
    "export_fmu",
    "export_machine",
    "export_machine_fmu",
    "export_models",
    "export_onnx",
    "machine_c",
    "to_c",
    "to_latex",
    "to_onnx",
    "to_python",
    "to_sympy",
    "to_text",
    "verify_models",
]
