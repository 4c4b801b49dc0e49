"""Models out of Python: `c` writes C99."""

from polydraulic.export.c import c_name, export_c, to_c

__all__ = ["c_name", "export_c", "to_c"]
