"""Networks that somebody has trained, for the machine that is driven or for its shadow."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.flow.dispatch import build_flow
from polydraulic.networks.model.model_file import load_models
from polydraulic.parameters.layout.schema import LayoutMachine

NETWORKS = ("polynomial", "neural")


def with_networks(
    machine: LayoutMachine | str | Path, flow: str, shadow: str | None, models: Sequence[Path]
) -> tuple[Any, Any]:
    """Flow model and shadow, with networks from files in the one of both that is made of networks.

    Raises
    ------
    InputError
        Files where neither or both are made of networks; files that cannot be read, or do not fit the machine.
    """
    if not models:
        return flow, shadow
    of = [name in NETWORKS for name in (flow, shadow)]
    if sum(of) != 1:
        raise InputError(
            f"model files go with one flow model of networks: flow is {flow!r} and shadow {shadow!r}, where one of both must be one of {list(NETWORKS)}"
        )
    found = [model for path in models for model in load_models(path)]
    flow_or_shadow = build_flow(str(shadow if of[1] else flow), machine, models=found)
    return (flow_or_shadow, shadow) if of[0] else (flow, flow_or_shadow)
