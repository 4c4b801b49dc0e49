"""Lags in words: what those who run a dynamic model elsewhere have to know."""

from collections.abc import Sequence
from itertools import pairwise

from polydraulic.networks.model.lags import Dynamics
from polydraulic.networks.model.model import Model, Variable

_HOURS = 7200.0  # s; beyond, no log tells how long


def lags_in_words(dynamics: Dynamics) -> str:
    """What a dynamic model reads, and when: "valve 0, 1; pressure 1 to 3 rows ago"."""
    steps: dict[str, list[int]] = {}
    for lag in dynamics.lags:
        steps.setdefault(lag.signal, []).append(lag.steps)
    return "; ".join(f"{name} {rows_in_words(sorted(some))}" for name, some in steps.items()) + " rows ago"


def strength_in_words(dynamics: Dynamics) -> str:
    """How much the strength of a joint differs, and what a run makes of it; of a model without one nothing."""
    known = dynamics.strength
    if known is None:
        return ""
    seconds = None if dynamics.raster is None else known.memory * dynamics.raster
    lasts = f"for about {known.memory:.0f} rows" if seconds is None else f"for about {float(f'{seconds:.3g}'):g} s"
    if seconds is not None and seconds > _HOURS:
        lasts = "for hours"
    return (
        f"its strength differs from one time to another by {known.spread:.1%} both ways and {known.lean:.1%} of one way against the other (standard "
        f"deviations), and stays {lasts}; a run that restarts goes by what measured rows show"
    )


def change_in_words(output: Variable, dynamics: Dynamics) -> str:
    """What an output changes by from row to row: "-0.2 to 0.2 rad"."""
    low, high = dynamics.step
    unit = f" {output.unit}" if output.unit not in ("", "1") else ""
    return f"{low:.6g} to {high:.6g}{unit}"


def dynamic_notes(models: Sequence[Model]) -> list[str]:
    """What an export, or a proof, of dynamic models is about, in words; nothing of static ones."""
    steps: dict[str, list[str]] = {}
    stronger = [model.output.name for model in models if model.dynamics and model.dynamics.strength]
    for model in models:
        if model.dynamics is None:
            continue
        raster = "" if model.dynamics.raster is None else f", rows {model.dynamics.raster:g} s apart"
        change = f"{model.output.name} by {change_in_words(model.output, model.dynamics)}"
        steps.setdefault(lags_in_words(model.dynamics) + raster, []).append(change)
    found = [
        f"dynamic, a function of lagged values: {lags}. Whoever calls it shifts them from row to row, and lets "
        f"the output change from the last one {', '.join(changes)} at most"
        for lags, changes in steps.items()
    ]
    if stronger:
        found.append(
            f"{', '.join(stronger)}: as strong as in the mean; a run in Python or C, or as an FMU, follows strengths from measured rows, and here whoever "
            "knows a joint to be weaker or stronger multiplies its change by that"
        )
    return found


def rows_in_words(steps: Sequence[int]) -> str:
    """Numbers in words: 1 to 4 where none is missing."""
    if len(steps) > 2 and all(b - a == 1 for a, b in pairwise(steps)):
        return f"{steps[0]} to {steps[-1]}"
    return ", ".join(str(step) for step in steps)
