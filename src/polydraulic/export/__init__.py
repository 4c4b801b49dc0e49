"""Out of Python: `c` writes models as C99, `formula` text, SymPy, LaTeX and plain Python; `machine` the machine as C99."""

from polydraulic.export.bundle import Bundle, bundle, c_name
from polydraulic.export.c import export_c, to_c
from polydraulic.export.formula import to_latex, to_python, to_sympy, to_text
from polydraulic.export.machine import export_machine, machine_c

__all__ = [
    "Bundle", "bundle", "c_name", "export_c", "export_machine", "machine_c", "to_c", "to_latex", "to_python", "to_sympy",
    "to_text",
]  # fmt: skip
