"""The units that the thesis prints: its chapters keep them, whatever the rest of the package shows."""

import numpy as np

from polydraulic.tables import Table, shown_column


def in_field_units(table: Table, name: str) -> tuple[np.ndarray, str]:
    """A column, (n_row,), and its unit as the thesis prints them: in, psi, in3/s, deg."""
    return shown_column(table, name, "field")
