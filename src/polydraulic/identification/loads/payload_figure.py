"""A payload over time, as a picture."""

from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.identification.loads.tip_loads import PayloadEstimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINE, _BAND = "#1f4e79", "#9ec5e8"


def plot_payload(found: PayloadEstimate, *, units: str = DEFAULT) -> "Figure":
    """Draw a payload window by window, each with twice its standard error, and the mean of the log.

    Parameters
    ----------
    found : PayloadEstimate
        From `estimate_payload`.
    units : str
        ``"metric"``, ``"field"`` or ``"si"``.

    Returns
    -------
    matplotlib Figure
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.0), dpi=100, layout="constrained")
    axis = figure.subplots()
    known = np.isfinite(found.error)
    scale = as_shown(1.0, "kg", units)
    axis.errorbar(
        found.time[known], scale * found.payload[known], 2.0 * scale * found.error[known], fmt="o", color=_LINE, ecolor=_BAND,
        elinewidth=4, markersize=4, label="windows, with twice their standard error",
    )  # fmt: skip
    mean, error = scale * found.mean, scale * found.mean_error
    axis.axhline(mean, color="#e07a1f", linewidth=1.4, label=f"mean of the log, {mean:.0f} ± {error:.0f}")
    axis.set_xlabel("time [s]")
    axis.set_ylabel(f"payload [{shown_unit('kg', units)}]")
    axis.grid(alpha=0.25)
    axis.legend(loc="best", fontsize=8)
    return figure
