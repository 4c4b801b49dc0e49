"""Models as they are shown: in units that people read, and still models.

A network works on normalized variables, so that another unit only scales its normalizers, domain and bounds. What comes out is for
pages, pictures and printed lines; files, exports and proofs are of the model itself.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, shown, shown_unit
from polydraulic.measure.log_units import Conversion
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import Partition, Split, box_name
from polydraulic.networks.model.table import UNBOUNDED, Network
from polydraulic.networks.proof.bounds import Leaving, ModelBounds, RangeCheck, range_sentence


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
        dynamics=model.dynamics and replace(model.dynamics, step=_ends(model.dynamics.step, given, units)),
    )
    names = dict(zip(model.region_names(), region_names(found), strict=True))
    return replace(found, training=_training(model.training, names, given, units))


def region_names(model: Model) -> list[str]:
    """Regions in words with the units of their borders, one per network."""
    return [box_name(box, [str(variable) for variable in model.inputs]) for box in model.region_boxes()]


def conversion_of(unit: str, units: str = DEFAULT) -> Conversion:
    """How a column in `unit` converts to what it is shown in, for what is said of deadbands and coverage."""
    return Conversion(1.0 / shown(1.0, unit, units), 0.0, unit, shown_unit(unit, units))


def said_of_bounds(model: Model, bounds: ModelBounds, units: str = DEFAULT) -> list[str]:
    """Proved ranges of a model's output and slopes, in lines as they are shown."""
    read, unit = shown_model(model, units), model.output.unit

    def span(low: float, high: float) -> str:
        return f"{shown(low, unit, units):.6g} to {shown(high, unit, units):.6g}"

    lines = [f"{read.output}: proved range {span(bounds.low, bounds.high)}"]
    for name, region in zip(region_names(read), bounds.regions, strict=True):
        if region is None:
            continue
        lines.append(f"  {name}: {span(region.low, region.high)}, slopes")
        for variable, ends in zip(model.inputs, region.slopes, strict=True):
            low, high = (shown(end, unit, units) / shown(1.0, variable.unit, units) for end in ends)
            lines.append(
                f"    by {Variable(variable.name, shown_unit(variable.unit, units))!s:28s} {low:12.5g} to {high:12.5g}"
            )
    return lines


def said_of_range(model: Model, answer: RangeCheck, units: str = DEFAULT) -> str:
    """Whether a model stays in a range, in a sentence as it is shown."""
    read, unit = shown_model(model, units), model.output.unit
    names = dict(zip(model.region_names(), region_names(read), strict=True))
    return range_sentence(
        read,
        answer._replace(
            low=shown(answer.low, unit, units),
            high=shown(answer.high, unit, units),
            asked=_ends(answer.asked, unit, units),
            leaving=tuple(
                Leaving(
                    names[found.region],
                    shown_columns(found.point[None], [variable.unit for variable in model.inputs], units)[0],
                    shown(found.value, unit, units),
                )
                for found in answer.leaving
            ),
            undecided=tuple(names[region] for region in answer.undecided),
        ),
    )


def shown_columns(X: np.ndarray, read: Sequence[str], units: str) -> np.ndarray:
    """Columns of (n_row, n_column) in the units `read` as they are shown."""
    return np.column_stack([shown(X[:, k], unit, units) for k, unit in enumerate(read)])


def _network(network: Network, read: Sequence[str], given: str, units: str) -> Network:
    inputs = {
        name: tuple(_bound(value, unit, units) for value, unit in zip(getattr(network, name), read, strict=True))
        for name in ("x_mean", "x_scale", "x_low", "x_high")
    }
    outputs = {name: _bound(getattr(network, name), given, units) for name in ("y_mean", "y_scale", "y_low", "y_high")}
    return replace(network, **inputs, **outputs)  # type: ignore[arg-type]


def _ends(ends: tuple[float, float], unit: str, units: str) -> tuple[float, float]:
    return _bound(ends[0], unit, units), _bound(ends[1], unit, units)


def _bound(value: float, unit: str, units: str) -> float:
    return value if abs(value) >= UNBOUNDED else shown(value, unit, units)


def _partition(partition: Partition, read: Sequence[str], units: str) -> Partition:
    if not isinstance(partition, Split):
        return partition
    ways = (_partition(way, read, units) for way in (partition.below, partition.above))
    return Split(partition.axis, shown(partition.at, read[partition.axis], units), *ways)


def _training(value: Any, regions: dict[str, str], unit: str, units: str, key: str = "") -> Any:
    """What a fit stated: errors and half widths in the output's unit, regions by their names; flows of a machine stay in SI."""
    if isinstance(value, dict):
        return {name: _training(entry, regions, unit, units, name) for name, entry in value.items()}
    if isinstance(value, list):
        return [_training(entry, regions, unit, units, key) for entry in value]
    if isinstance(value, str):
        return regions.get(value, value) if key == "region" else value
    error = key == "interval_half_widths" or (key.endswith(("rms", "largest")) and "flow" not in key)
    return shown(value, unit, units) if error and isinstance(value, float) else value
