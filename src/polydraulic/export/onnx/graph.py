"""An ONNX graph while it grows, and its values with the arithmetic of numbers."""

from typing import Any

import numpy as np


class Graph:
    """Nodes and constants while a graph grows; a value is known by its name."""

    def __init__(self, dtype: Any) -> None:
        from onnx import TensorProto

        self.dtype = dtype
        self.type = TensorProto.DOUBLE if dtype is np.float64 else TensorProto.FLOAT
        self.nodes: list[Any] = []
        self.constants: dict[str, Any] = {}
        self._known: dict[bytes, str] = {}

    def op(self, kind: str, *inputs: str, to_name: str | None = None, **attributes: Any) -> str:
        """Add an operation; the name of its value."""
        from onnx import helper

        name = to_name or f"t{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name

    def constant(self, values: np.ndarray) -> str:
        """Name of a constant, which stands in the graph once."""
        from onnx import numpy_helper

        key = repr((values.dtype, values.shape)).encode() + values.tobytes()
        if key not in self._known:
            name = f"c{len(self.constants)}"
            self._known[key] = name
            self.constants[name] = numpy_helper.from_array(values, name)
        return self._known[key]

    def number(self, value: float) -> str:
        """Name of a constant of the graph's precision."""
        return self.constant(np.array(value, dtype=self.dtype))


class GraphValue:
    """A value in the graph with the arithmetic of a number, so that formulas become operations."""

    def __init__(self, graph: Graph, name: str) -> None:
        self.graph, self.name = graph, name

    def _with(self, kind: str, other: "GraphValue | float", swapped: bool = False) -> "GraphValue":
        name = other.name if isinstance(other, GraphValue) else self.graph.number(other)
        pair = (name, self.name) if swapped else (self.name, name)
        return GraphValue(self.graph, self.graph.op(kind, *pair))

    def __add__(self, other: "GraphValue | float") -> "GraphValue":
        return self._with("Add", other)

    def __radd__(self, other: float) -> "GraphValue":
        return self._with("Add", other, swapped=True)

    def __sub__(self, other: "GraphValue | float") -> "GraphValue":
        return self._with("Sub", other)

    def __mul__(self, other: "GraphValue | float") -> "GraphValue":
        return self._with("Mul", other)

    def __rmul__(self, other: float) -> "GraphValue":
        return self._with("Mul", other, swapped=True)

    def clipped(self, low: float, high: float) -> "GraphValue":
        """As `between`, by numbers."""
        return GraphValue(self.graph, self.graph.op("Clip", self.name, self.graph.number(low), self.graph.number(high)))

    def between(self, low: "GraphValue", high: "GraphValue") -> "GraphValue":
        """The value, moved to the nearer end where it lies outside."""
        graph = self.graph
        return GraphValue(graph, graph.op("Min", graph.op("Max", self.name, low.name), high.name))

    def sigmoid(self) -> "GraphValue":
        """Logistic function of the value."""
        graph = self.graph
        power = graph.op("Exp", graph.op("Neg", self.clipped(-700.0, 700.0).name))
        return GraphValue(graph, graph.op("Div", graph.number(1.0), graph.op("Add", graph.number(1.0), power)))

    def ramp(self) -> "GraphValue":
        """The nearest number from 0 to 1."""
        return self.clipped(0.0, 1.0)
