"""Model files: fitted models as JSON, data only.

A file holds one model or several (one per output). Reading checks everything that the compiled evaluation relies on,
so that a damaged file is an error and never a wrong number. Files of older schemas are read: what they hold is first put
into the form of today.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.networks.model.lags import Dynamics, JointStrength, Lag
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.nodes import KIND_NAMES, N_INPUTS, terms
from polydraulic.networks.model.overflow import overflows
from polydraulic.networks.model.partition import Partition, Split, grid, networks_of, region_boxes
from polydraulic.networks.model.table import UNBOUNDED, Network, Node

SCHEMA = 2  # 1 had a grid of edges in the place of a partition
_MOST_STEPS = 1_000_000  # that a signal may be read ago
_SCALARS = ("y_mean", "y_scale", "y_low", "y_high")
_VECTORS = ("x_mean", "x_scale", "x_low", "x_high")


def dump_models(models: Sequence[Model]) -> str:
    """`models` as JSON text; numbers are written so that they read back exactly."""
    data = {
        "format": "polydraulic model",
        "schema": SCHEMA,
        "models": [_model_data(model) for model in models],
    }
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def model_ending(path: str | Path) -> Path:
    """Path of a model file, or an InputError."""
    path = Path(path)
    if path.suffix.lower() != ".json":
        raise InputError(f"{path}: a model file ends in .json")
    return path


def save_models(models: Sequence[Model], path: str | Path) -> None:
    """Write `models` to the file `path`, which ends in ``.json``, whole or not at all.

    Raises
    ------
    InputError
        Another ending, or a place that cannot be written.
    """
    write_text(model_ending(path), dump_models(models))


def load_models(path: str | Path) -> list[Model]:
    """Read the model file at `path`.

    Raises
    ------
    InputError
        Missing, damaged, or of a newer schema than this version reads.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"model file {path}: no such file")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a model file ({error})") from error
    return parse_models(text, str(path))


def parse_models(text: str, name: str) -> list[Model]:
    """Models from JSON text; `name` says in errors where it came from."""
    try:
        data = json.loads(text)
    except RecursionError as error:
        raise InputError(f"{name}: not a model file: its JSON is nested too deep") from error
    except ValueError as error:  # also whole numbers of thousands of digits
        raise InputError(f"{name}: not a model file: {error}") from error
    if not isinstance(data, dict) or data.get("format") != "polydraulic model":
        raise InputError(f"{name}: not a polydraulic model file")
    schema = data.get("schema")
    if type(schema) is not int or not 1 <= schema <= SCHEMA:
        newer = type(schema) is int and schema > SCHEMA
        mend = "it was written by a newer version: update polydraulic" if newer else "write the model again"
        raise InputError(f"{name}: has schema {schema!r}, this version reads 1 to {SCHEMA}; {mend}")
    try:
        models = [_read_model(item if schema > 1 else _from_schema_1(item)) for item in data["models"]]
    except RecursionError as error:
        raise InputError(f"{name}: damaged model file: its partition is nested too deep") from error
    except (KeyError, TypeError, ValueError, IndexError) as error:
        what = f"missing {error}" if isinstance(error, KeyError) else str(error)
        raise InputError(f"{name}: damaged model file: {what}") from error
    if not models:
        raise InputError(f"{name}: holds no model")
    return models


def _model_data(model: Model) -> dict[str, Any]:
    return {
        "output": vars(model.output),
        "inputs": [vars(variable) for variable in model.inputs],
        "partition": _partition_data(model.partition),
        "training": model.training,
        **({} if model.dynamics is None else {"dynamics": _dynamics_data(model.dynamics)}),
        "networks": [
            {
                **{name: list(getattr(network, name)) for name in _VECTORS},
                **{name: getattr(network, name) for name in _SCALARS},
                "nodes": [
                    {"kind": KIND_NAMES[node.kind], "inputs": list(node.inputs), "coef": list(node.coef)}
                    for node in network.nodes
                ],
            }
            for network in model.networks
        ],
    }


def _from_schema_1(data: Any) -> dict[str, Any]:
    edges: dict[int, tuple[float, ...]] = {}
    for item in data["edges"]:
        axis, cuts = item["input"], _floats(item["at"], "edges")
        _require(axis not in edges and len(cuts) > 0, f"the edges {cuts} of input {axis!r}")
        edges[axis] = cuts
    return {**data, "partition": _partition_data(grid(edges))}


def _read_model(data: Any) -> Model:
    inputs = tuple(_read_variable(item) for item in data["inputs"])
    _require(len(inputs) > 0, "a model without inputs")
    output = _read_variable(data["output"])
    networks = tuple(_read_network(item, len(inputs)) for item in data["networks"])
    partition = _read_partition(data["partition"], len(inputs), len(networks))
    found = networks_of(partition)
    _require(sorted(found) == list(range(len(networks))), f"the partition leads to networks {found} of {len(networks)}")
    boxes = region_boxes(partition, len(inputs)).values()
    _require(all((box[:, 0] < box[:, 1]).all() for box in boxes), "the partition has a region that is empty")
    dynamics = _read_dynamics(data["dynamics"], output.name, len(inputs)) if "dynamics" in data else None
    training = data["training"]
    _require(isinstance(training, dict), f"training holds {training!r}")
    json.dumps(training, allow_nan=False)  # else it could not be written again
    return Model(inputs, output, networks, partition, training, dynamics)


def _read_variable(data: Any) -> Variable:
    name, unit = data["name"], data["unit"]
    _require(isinstance(name, str) and isinstance(unit, str), f"a variable of name {name!r}, unit {unit!r}")
    return Variable(name, unit)


def _dynamics_data(dynamics: Dynamics) -> dict[str, Any]:
    return {
        "lags": [{"signal": lag.signal, "steps": lag.steps} for lag in dynamics.lags],
        "step": list(dynamics.step),
        "raster": dynamics.raster,
        **({} if dynamics.strength is None else {"strength": vars(dynamics.strength)}),
    }


def _read_dynamics(data: Any, output: str, n_input: int) -> Dynamics:
    lags = tuple(Lag(str(item["signal"]), item["steps"]) for item in data["lags"])
    _require(len(lags) == n_input, f"{len(lags)} lags for {n_input} inputs")
    for lag in lags:
        least = 1 if lag.signal == output else 0
        good = type(lag.steps) is int and least <= lag.steps <= _MOST_STEPS
        _require(good, f"{lag.signal} is read {_short(lag.steps)} steps ago; it may be {least} to {_MOST_STEPS}")
    low, high = _floats(data["step"], "step")
    _require(low <= high, f"the smallest step {low} exceeds the largest one {high}")
    raster = None if data["raster"] is None else _floats([data["raster"]], "raster")[0]
    _require(raster is None or raster > 0.0, f"raster is {raster!r}")
    strength = _read_strength(data["strength"]) if "strength" in data else None
    return Dynamics(lags, (low, high), raster, strength)


def _read_strength(data: Any) -> JointStrength:
    rows, names = data["rows"], ("spread", "lean", "memory", "noise")
    _require(sorted(data) == sorted(("rows", *names)), f"a strength of {_short(sorted(data))}")
    _require(type(rows) is int and 1 <= rows <= _MOST_STEPS, f"a strength over {_short(rows)} rows")
    numbers = _floats([data[name] for name in names], "strength")
    for name, value in zip(names, numbers, strict=True):
        _require(value > 0.0, f"{name} of a strength is {value!r}: it is above 0")
    return JointStrength(rows, *numbers)


def _partition_data(partition: Partition) -> Any:
    if not isinstance(partition, Split):
        return partition
    below, above = _partition_data(partition.below), _partition_data(partition.above)
    return {"input": partition.axis, "at": partition.at, "below": below, "above": above}


def _read_partition(data: Any, n_input: int, depth: int) -> Partition:
    if type(data) is int:
        return data
    _require(isinstance(data, dict), f"the partition holds {data!r}")
    _require(depth > 0, "the partition has more splits than networks")  # also ends a tree of any depth
    axis, (at,) = data["input"], _floats([data["at"]], "partition")
    _require(type(axis) is int and 0 <= axis < n_input, f"a split of input {axis!r}")
    return Split(axis, at, *(_read_partition(data[side], n_input, depth - 1) for side in ("below", "above")))


def _read_network(data: Any, n_input: int) -> Network:
    vectors: dict[str, Any] = {name: _floats(data[name], name) for name in _VECTORS}
    for name, values in vectors.items():
        _require(len(values) == n_input, f"{name} has {len(values)} values for {n_input} inputs")
    _require(all(scale > 0.0 for scale in vectors["x_scale"]), "x_scale must be positive")
    _require(all(a <= b for a, b in zip(vectors["x_low"], vectors["x_high"], strict=True)), "x_low exceeds x_high")
    nodes: list[Node] = []
    for item in data["nodes"]:
        _require(item["kind"] in KIND_NAMES, f"unknown node kind {item['kind']!r}")
        kind = KIND_NAMES.index(item["kind"])
        slots = tuple(item["inputs"])
        _require(
            len(slots) == N_INPUTS[kind] if kind < len(N_INPUTS) else len(slots) > 0,
            f"{item['kind']} node of {slots}",
        )
        _require(
            all(type(slot) is int and 0 <= slot < n_input + len(nodes) for slot in slots),
            f"node {len(nodes) + 1} reads {_short(slots)}; it may read slots 0 to {n_input + len(nodes) - 1}",
        )
        _require(len(slots) <= n_input + len(nodes), f"node {len(nodes) + 1} reads a slot twice: {_short(slots)}")
        coef = _floats(item["coef"], "coef")
        _require(len(coef) == len(terms(kind, len(slots))), f"{item['kind']} node with {len(coef)} coefficients")
        nodes.append(Node(kind, slots, coef))
    scalars: dict[str, Any] = dict(zip(_SCALARS, _floats([data[name] for name in _SCALARS], "unitizer"), strict=True))
    low, high = scalars["y_low"], scalars["y_high"]
    _require(low <= high, f"y_low = {low!r} exceeds y_high = {high!r}")
    # zero is the scale of a network of a constant output, which has nodes all the same
    _require(scalars["y_scale"] >= 0.0, f"y_scale is {scalars['y_scale']!r}; it must not be negative")
    if not nodes:
        scalars["y_mean"] += 0.0  # a constant has no negative zero, wherever it is evaluated
    network = Network(nodes=tuple(nodes), **vectors, **scalars)
    _require(not overflows(network), "a network overflows in its domain: its scales, limits or coefficients are wrong")
    return network


def _floats(values: Any, name: str) -> tuple[float, ...]:
    for value in values:
        _require(isinstance(value, int | float) and not isinstance(value, bool), f"{name} holds {_short(value)}")
        _require(abs(value) <= UNBOUNDED, f"{name} holds {_short(value)}")
    return tuple(float(value) for value in values)


def _short(value: Any) -> str:
    """A value as it stands in a message, cut where it is long."""
    text = "a whole number of hundreds of digits" if type(value) is int and abs(value) > UNBOUNDED else repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."


def _require(good: bool, what: str) -> None:
    if not good:
        raise ValueError(what)
