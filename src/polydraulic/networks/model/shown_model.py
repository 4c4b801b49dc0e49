"""Models as they are shown: in units that people read, and still models.

A network works on normalized variables, so that another unit only scales its normalizers, domain and bounds. What comes out is for
pages, pictures and printed lines; files, exports and proofs are of the model itself.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.networks.model.lags import Dynamics
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import Partition, Split, box_name
from polydraulic.networks.model.table import UNBOUNDED, Network


def shown_model(model: Model, units: str = DEFAULT) -> Model:
    """A model of the same quantities in the units they are shown in; inputs and outputs in units of their own stay.

    Parameters
    ----------
    model : Model
    units : str
        ``"metric"``, ``"field"`` or ``"si"``.
    """
    variables = [*model.inputs, model.output]
    if all(shown_unit(v.unit, units) == v.unit for v in variables):
        return model
    named = [Variable(v.name, shown_unit(v.unit, units)) for v in variables]
    read, given = [v.unit for v in model.inputs], model.output.unit
    found = replace(
        model,
        inputs=tuple(named[:-1]),
        output=named[-1],
        networks=tuple(_network(network, read, given, units) for network in model.networks),
        partition=_partition(model.partition, read, units),
        dynamics=model.dynamics and _dynamics(model.dynamics, given, units),
    )
    names = dict(zip(model.region_names(), region_names(found), strict=True))
    return replace(found, training=_training(model.training, names, given, units))


def _dynamics(dynamics: Dynamics, unit: str, units: str) -> Dynamics:
    strength = dynamics.strength
    shown = strength and replace(strength, noise=as_shown(strength.noise, unit, units))
    return replace(dynamics, step=ends_in(dynamics.step, unit, units), strength=shown)


def region_names(model: Model) -> list[str]:
    """Regions in words with the units of their borders, one per network."""
    return [box_name(box, [str(variable) for variable in model.inputs]) for box in model.region_boxes()]


def shown_columns(X: np.ndarray, read: Sequence[str], units: str) -> np.ndarray:
    """Columns of (n_row, n_column) in the units `read` as they are shown."""
    return np.column_stack([as_shown(X[:, k], unit, units) for k, unit in enumerate(read)])


def _network(network: Network, read: Sequence[str], given: str, units: str) -> Network:
    inputs = {
        name: tuple(_bound(value, unit, units) for value, unit in zip(getattr(network, name), read, strict=True))
        for name in ("x_mean", "x_scale", "x_low", "x_high")
    }
    outputs = {name: _bound(getattr(network, name), given, units) for name in ("y_mean", "y_scale", "y_low", "y_high")}
    return replace(network, **inputs, **outputs)  # type: ignore[arg-type]


def ends_in(ends: tuple[float, float], unit: str, units: str) -> tuple[float, float]:
    """Low and high of a quantity in `unit` as they are shown; what is unbounded stays."""
    return _bound(ends[0], unit, units), _bound(ends[1], unit, units)


def _bound(value: float, unit: str, units: str) -> float:
    return value if abs(value) >= UNBOUNDED else as_shown(value, unit, units)


def _partition(partition: Partition, read: Sequence[str], units: str) -> Partition:
    if not isinstance(partition, Split):
        return partition
    ways = (_partition(way, read, units) for way in (partition.below, partition.above))
    return Split(partition.axis, as_shown(partition.at, read[partition.axis], units), *ways)


def _training(value: Any, regions: dict[str, str], unit: str, units: str, key: str = "") -> Any:
    """What a fit stated: errors and half widths in the output's unit, regions by their names; flows of a machine stay in SI."""
    if isinstance(value, dict):
        return {name: _training(entry, regions, unit, units, name) for name, entry in value.items()}
    if isinstance(value, list):
        return [_training(entry, regions, unit, units, key) for entry in value]
    if isinstance(value, str):
        return regions.get(value, value) if key == "region" else value
    error = key == "interval_half_widths" or (key.endswith(("rms", "largest")) and "flow" not in key)
    return as_shown(value, unit, units) if error and isinstance(value, float) else value
