"""Variables of a network that grows: its inputs and the outputs of its nodes, and terms of nodes on rows.

A variable is a row of memory, along which compiled loops run, some rows at a time, so that the terms of a node stay in the cache.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.model.nodes import term_steps
from polydraulic.networks.model.table import Node

ROWS = 128  # of which terms are held at a time


class GrownVariable(NamedTuple):
    """An input (without node) or a node's output."""

    node: Node | None  # its slots count variables, not the final network's slots
    ancestors: frozenset[int]  # nodes needed to compute it, itself included
    size: int  # coefficients of its own node


def variable_values(variables: list[GrownVariable], x: np.ndarray) -> np.ndarray:
    """All variables on rows `x` (n_row, n_input), one variable per row of the array."""
    values = np.empty((len(variables), len(x)))
    values[: x.shape[1]] = x.T
    for place, variable in enumerate(variables):
        if variable.node is not None:
            node_output(variable.node, values, values[place])
    return values


def node_output(node: Node, values: np.ndarray, output: np.ndarray) -> np.ndarray:
    """Output of a node (n_row,), written where it is to be, from the variables (n_variable, n_row) that it reads."""
    steps = steps_table(node.kind, len(node.inputs))
    columns, ones = np.empty((len(steps), ROWS)), np.ones(len(output))
    _output(values, ones, np.array(node.inputs), steps, np.array(node.coef), columns, output)
    return output


@cache
def steps_table(kind: int, n_inputs: int) -> np.ndarray:
    """How each term follows from an earlier one: `term_steps` as an array (n_term, 2)."""
    return np.array(term_steps(kind, n_inputs), dtype=np.int64)


@driver
def fill_terms(
    values: np.ndarray,
    root: np.ndarray,
    inputs: np.ndarray,
    steps: np.ndarray,
    first: int,
    end: int,
    columns: np.ndarray,
) -> None:
    """Terms of a node, each times the root of the row's weight, on the rows first <= row < end.

    Parameters
    ----------
    values : (n_variable, n_row) array
    root : (n_row,) array
    inputs : (n_input,) array of int
    steps : (n_term, 2) array of int
        From `steps_table`.
    first, end : int
    columns : (n_term or more, end - first or more) array
        One term per row; written.
    """
    n = end - first
    weight = root[first:end]
    for term in range(steps.shape[0]):
        earlier, place, column = steps[term, 0], steps[term, 1], columns[term]
        if place < 0:
            for i in range(n):
                column[i] = weight[i]
        else:
            x = values[inputs[place], first:end]
            if earlier < 0:
                for i in range(n):
                    column[i] = weight[i] * x[i]
            else:
                before = columns[earlier]
                for i in range(n):
                    column[i] = before[i] * x[i]


@driver
def _output(
    values: np.ndarray,
    ones: np.ndarray,
    inputs: np.ndarray,
    steps: np.ndarray,
    coef: np.ndarray,
    columns: np.ndarray,
    output: np.ndarray,
) -> None:
    for first in range(0, output.shape[0], columns.shape[1]):
        end = min(first + columns.shape[1], output.shape[0])
        fill_terms(values, ones, inputs, steps, first, end, columns)
        total = output[first:end]
        for i in range(end - first):
            total[i] = 0.0
        for term in range(coef.shape[0]):
            column, c = columns[term], coef[term]
            if c != 0.0:
                for i in range(end - first):
                    total[i] += c * column[i]


@driver
def count_before(needed: np.ndarray, sizes: np.ndarray, inputs: np.ndarray, k: np.ndarray) -> None:
    """Add to each candidate's number of coefficients those of all nodes that it needs, each once.

    Parameters
    ----------
    needed : (n_drawn, n_variable) array of bool
        Which nodes the variables that are drawn on need.
    sizes : (n_variable,) array of int
    inputs : (n_candidate, n_input) array of int
        Places among the variables that are drawn on.
    k : (n_candidate,) array of int
        Changed in place.
    """
    for candidate in range(k.shape[0]):
        for node in range(sizes.shape[0]):
            for place in range(inputs.shape[1]):
                if needed[inputs[candidate, place], node]:
                    k[candidate] += sizes[node]
                    break
