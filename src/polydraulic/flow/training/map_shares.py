"""How good trained networks are, as shares that people know, and which of them are worse than one would expect."""

from collections.abc import Mapping, Sequence
from typing import Any

from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine

LARGE = 0.05  # of the whole; those that come with the package stay below it


def map_shares(models: Sequence[Model], machine: LayoutMachine) -> dict[str, float]:
    """By output: the largest error that was found, as a share of the pump's flow or of the widest orifice.

    Parameters
    ----------
    models : sequence of Model
        From `train_layout` or `train_layout_perceptrons`.
    machine : LayoutMachine
        Whose circuits they have learnt.
    """
    flows = {f: c.pump.flow for c in machine.circuits for f in (c.name, *c.functions)}
    shares = {}
    for model in models:
        largest: Any = model.training["largest_error"]
        is_flow = model.output.unit == "m3/s"
        shares[model.output.name] = largest / (
            flows[model.output.name.split(".")[0]] if is_flow else model.networks[0].y_high
        )
    return shares


def large_errors(shares: Mapping[str, float], tolerance: float, regions: int | None) -> list[str]:
    """Say which networks are worse than `LARGE` and than what was asked, the worst first, and what to do; empty if none is.

    Parameters
    ----------
    shares : mapping from output to share
        From `map_shares`.
    tolerance : float
        That was asked for.
    regions : int or None
        That a network could have; None for perceptrons, of which more regions need not make better ones.
    """
    bad = {name: share for name, share in shares.items() if share > max(LARGE, tolerance)}
    if not bad:
        return []
    named = ", ".join(f"{name} ({bad[name]:.0%})" for name in sorted(bad, key=lambda name: -bad[name]))
    better = (
        "learn them with --kind polynomial"
        if regions is None
        else f"give them more regions, --regions {2 * regions} or more"
    )
    return [
        f"large errors on the map: {named} of the whole; where a run comes there, its flows are wrong by as much. "
        f"To do: {better}, and compare a run with that of flow 'exact'"
    ]
