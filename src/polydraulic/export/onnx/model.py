"""Models as ONNX: for batches of rows in any runtime.

Every node of a network becomes a few elementwise operations in the nesting of the compiled evaluation. A few networks see all rows,
and `Where` keeps those of the region; of many (`c.answers`) the numbers are gathered row by row from tables (`tables`).
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic import __version__
from polydraulic.errors import InputError
from polydraulic.export.c.answers import as_tables
from polydraulic.export.c.network import bounded, polynomial
from polydraulic.export.exported import Exported
from polydraulic.export.model_bundle import Bundle, bundle
from polydraulic.export.onnx.graph import Graph, GraphValue
from polydraulic.export.onnx.tables import answer_of_tables
from polydraulic.files import replacing
from polydraulic.networks.model.lag_words import dynamic_notes
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.partition import Partition, Split
from polydraulic.networks.model.slopes import domain_gain
from polydraulic.networks.model.table import Network, used_slots

if TYPE_CHECKING:
    import onnx

OPSET, _IR = 17, 8  # of 2022
_COARSE = 1e-4  # of an input's domain, from one float to the next: what is lost shows


def export_onnx(
    models: Sequence[Model], path: str | Path, *, name: str | None = None, real: str = "double", opset: int = OPSET
) -> Exported:
    """Write models as one ONNX graph.

    Parameters
    ----------
    models : sequence of Model
        One per output.
    path : str or Path
        Ends in .onnx.
    name : str, optional
        Name of the graph; the output's if there is one model, else "model".
    real : str
        "double" or "float".
    opset : int
        Version of the operators, at least 13.

    Returns
    -------
    Exported
        The graph: input ``x`` (rows, inputs), outputs ``y`` (rows, outputs) and ``domain`` (rows, 1), which is 0 inside and else
        how far outside, as a share of the domain's width. Names, units and domain are in the metadata.

    Raises
    ------
    InputError
        If onnx is missing, the models do not go together, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix != ".onnx":
        raise InputError(f"{path}: an ONNX graph ends in .onnx")
    whole = bundle(models, name=name)
    content = to_onnx(whole, real=real, opset=opset).SerializeToString()
    with replacing(path) as temporary:
        temporary.write_bytes(content)
    return Exported((path,), (*dynamic_notes(models), *(_coarse(whole) if real == "float" else ())))


def _coarse(whole: Bundle) -> list[str]:
    """Notes on inputs of which a float tells few numbers of the domain apart, far as they are from zero."""
    notes = []
    for variable, (low, high) in zip(whole.inputs, whole.domain().tolist(), strict=True):
        step = float(np.spacing(np.float32(max(abs(low), abs(high)))))
        if step > _COARSE * (high - low) > 0.0:
            notes.append(
                f"{variable.name}: from {low:.9g} to {high:.9g}, a float tells numbers apart by {step:.2g} only; subtract an offset before the model is "
                "fitted, or export as double"
            )
    return notes


def to_onnx(whole: Bundle, *, real: str = "double", opset: int = OPSET) -> "onnx.ModelProto":
    """ONNX model of a bundle.

    Parameters
    ----------
    whole : Bundle
    real : str
        "double" or "float".
    opset : int

    Returns
    -------
    onnx.ModelProto

    Raises
    ------
    InputError
        If onnx is missing, an option makes no sense, or a number of a model exceeds what a float can hold.
    """
    try:
        from onnx import checker, helper
    except ImportError as error:
        raise InputError("ONNX needs the package onnx: pip install polydraulic[export]") from error
    if real not in ("double", "float"):
        raise InputError(f"real = {real!r}: must be 'double' or 'float'")
    if opset < 13:
        raise InputError(f"opset = {opset}: must be at least 13")
    graph = Graph(np.float64 if real == "double" else np.float32)
    try:
        with np.errstate(over="raise"):
            _answers(graph, whole)
    except FloatingPointError:
        raise InputError(
            f"numbers of {', '.join(repr(v.name) for v in whole.outputs)} exceed what a float can hold, 3.4e38: fit in other units, or export as double"
        ) from None
    n, m = len(whole.inputs), len(whole.models)
    made = helper.make_model(
        helper.make_graph(
            graph.nodes,
            whole.name,
            [helper.make_tensor_value_info("x", graph.type, ["rows", n])],
            [helper.make_tensor_value_info("y", graph.type, ["rows", m]),
             helper.make_tensor_value_info("domain", graph.type, ["rows", 1])],
            list(graph.constants.values()),
        ),
        opset_imports=[helper.make_opsetid("", opset)],
        producer_name="polydraulic",
        producer_version=__version__,
        doc_string="; ".join([f"{', '.join(map(str, whole.outputs))} from {', '.join(map(str, whole.inputs))}", *dynamic_notes(whole.models)]),
    )  # fmt: skip
    made.ir_version = _IR if opset <= OPSET else 10
    low, high = whole.domain().T.tolist()
    about = [
        {"name": v.name, "unit": v.unit, "low": a, "high": b} for v, a, b in zip(whole.inputs, low, high, strict=True)
    ]
    results = [{"name": v.name, "unit": v.unit} for v in whole.outputs]
    helper.set_model_props(made, {"inputs": json.dumps(about), "outputs": json.dumps(results)})
    checker.check_model(made)
    return made


def _answers(graph: Graph, whole: Bundle) -> None:
    """Add what leads from the inputs to the answers and the distance outside."""
    columns = [graph.op("Gather", "x", graph.constant(np.array([i])), axis=1) for i in range(len(whole.inputs))]
    invalid = graph.op("Cast", graph.op("IsNaN", "x"), to=graph.type)
    count = graph.op("ReduceSum", invalid, graph.constant(np.array([1])), keepdims=1)
    is_nan = graph.op("Greater", count, graph.number(0.0))
    outputs, distances = [], []
    for model, place in zip(whole.models, whole.places, strict=True):
        own = [columns[i] for i in place]
        if as_tables(whole) and isinstance(model.partition, Split):
            y, far = answer_of_tables(graph, model, own)
            outputs.append(y)
            distances.append(far)
            continue
        parts = [(_value(graph, network, own), _distance(graph, network, own)) for network in model.networks]
        y, far = _chosen(graph, model.partition, own, parts)
        outputs.append(y)
        distances.append(far)
    y = graph.op("Concat", *outputs, axis=1)
    far = graph.op("Max", *distances) if len(distances) > 1 else distances[0]
    graph.op("Where", is_nan, graph.number(np.nan), y, to_name="y")
    graph.op("Where", is_nan, graph.number(float(np.finfo(graph.dtype).max)), far, to_name="domain")


def _value(graph: Graph, network: Network, columns: Sequence[str]) -> str:
    inputs, nodes = used_slots(network)
    slots: dict[str, Any] = {"sigmoid": GraphValue.sigmoid, "ramp": GraphValue.ramp}
    for i in inputs:
        inside = GraphValue(graph, columns[i]).clipped(network.x_low[i], network.x_high[i])
        slots[f"n{i}"] = (inside - network.x_mean[i]) * (1.0 / network.x_scale[i])
    names = [f"n{i}" for i in range(network.n_inputs)] + [f"z{k}" for k in range(len(network.nodes))]
    for k in nodes:  # the text of a node holds numbers and the names of slots
        slots[f"z{k}"] = eval(polynomial(network.nodes[k], names), {"__builtins__": {}}, slots)
    if not network.nodes:
        value = min(max(network.y_mean, network.y_low), network.y_high)
        return (GraphValue(graph, columns[0]).clipped(0.0, 0.0) * 0.0 + value).name
    y = network.y_mean + network.y_scale * slots[names[-1]]
    return (y.clipped(network.y_low, network.y_high) if bounded(network) else y).name


def _distance(graph: Graph, network: Network, columns: Sequence[str]) -> str:
    shares = domain_gain(np.array(network.x_low), np.array(network.x_high))
    found = [graph.number(0.0)]
    for column, low, high, share in zip(columns, network.x_low, network.x_high, shares.tolist(), strict=True):
        x = GraphValue(graph, column)
        below = GraphValue(graph, graph.op("Sub", graph.number(low), column))
        found += [(below * share).name, ((x - high) * share).name]
    return graph.op("Max", *found)


def _chosen(
    graph: Graph, partition: Partition, columns: Sequence[str], parts: Sequence[tuple[str, str]]
) -> tuple[str, str]:
    if not isinstance(partition, Split):
        return parts[partition]
    is_above = graph.op("Greater", columns[partition.axis], graph.number(partition.at))
    above, below = (_chosen(graph, part, columns, parts) for part in (partition.above, partition.below))
    y, far = (graph.op("Where", is_above, a, b) for a, b in zip(above, below, strict=True))
    return y, far
