"""Models out of Python: `c` writes C99, `formula` text, SymPy, LaTeX and plain Python."""

from polydraulic.export.bundle import Bundle, bundle, c_name
from polydraulic.export.c import export_c, to_c
from polydraulic.export.formula import to_latex, to_python, to_sympy, to_text

__all__ = ["Bundle", "bundle", "c_name", "export_c", "to_c", "to_latex", "to_python", "to_sympy", "to_text"]
