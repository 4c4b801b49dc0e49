"""Nested named tuples as two flat arrays, and the text of the kernels that put them together again.

A call of compiled code from Python takes the longer the more arguments it has, and a machine has hundreds of numbers, each an argument.
Two arrays are two arguments; the compiled driver reads the numbers from them, once a call.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from polydraulic.flow.layout.text_module import written_name
from polydraulic.simulation.layout.expand import expanded


class Packed(NamedTuple):
    """What `pack_tree` makes of nested named tuples.

    Attributes
    ----------
    numbers : (n,) array of float
        Floats in their order, then the content of arrays of floats.
    whole : (m,) array of int
        Integers, conditions, and place and shape of each array, in their order; then the content of arrays of integers.
    """

    numbers: np.ndarray
    whole: np.ndarray


def pack_tree(tree: Any) -> Packed:
    """Pack a named tuple of floats, integers, conditions, arrays and named tuples of these."""
    leaves = list(_leaves(tree))
    floats = [x for x in leaves if not isinstance(x, int | np.ndarray)]
    n_whole = sum(1 if isinstance(x, int) else 2 + x.ndim for x in leaves if isinstance(x, int | np.ndarray))
    ends = {True: len(floats), False: n_whole}
    whole: list[int] = []
    contents: dict[bool, list[np.ndarray]] = {True: [], False: []}
    for leaf in leaves:
        if isinstance(leaf, np.ndarray):
            kind = leaf.dtype == np.float64
            whole += [ends[kind], ends[kind] + leaf.size, *leaf.shape]
            ends[kind] += leaf.size
            contents[kind].append(leaf.ravel())
        elif isinstance(leaf, int):
            whole.append(int(leaf))
    return Packed(
        np.concatenate([np.array(floats, dtype=np.float64), *contents[True]]),
        np.concatenate([np.array(whole, dtype=np.int64), *contents[False]]),
    )


def unpack_text(trees: Mapping[str, Any]) -> str:
    """Kernels ``unpack_NAME(numbers, whole)`` that give the parts of a tree that is packed as a whole.

    Parameters
    ----------
    trees : mapping from name to named tuple
        In the order in which they are packed: ``pack_tree(tuple(trees.values()))``.

    Returns
    -------
    str
        Imports, then kernels. It depends on types and numbers of axes alone.
    """
    imports: dict[str, set[str]] = {}
    kernels, place = [], _Place(0, 0)
    for name, tree in trees.items():
        text, place = _expression(tree, place, imports)
        head = f"@kernel\ndef unpack_{name}(numbers: np.ndarray, whole: np.ndarray) -> {written_name(type(tree))}:"
        kernels.append(f"{head}\n    'Numbers of {name}.'\n    return {text}\n")
    lines = [f"from {module} import {', '.join(sorted(names))}" for module, names in sorted(imports.items())]
    return "\n".join(lines) + "\n\n\n" + expanded("\n\n".join(kernels), {})


def _leaves(tree: Any) -> Iterator[Any]:
    for part in tree:
        if isinstance(part, tuple):
            yield from _leaves(part)
        else:
            yield part


class _Place(NamedTuple):
    """How many floats and integers come before."""

    number: int
    whole: int


def _expression(tree: Any, place: _Place, imports: dict[str, set[str]]) -> tuple[str, _Place]:
    """Source of what makes a part, and the place of the next one."""
    i, j = place
    if isinstance(tree, np.ndarray):
        source = "numbers" if tree.dtype == np.float64 else "whole"
        text = f"{source}[whole[{j}]:whole[{j + 1}]]"
        if tree.ndim > 1:
            text += f".reshape(({', '.join(f'whole[{j + 2 + k}]' for k in range(tree.ndim))}))"
        return text, _Place(i, j + 2 + tree.ndim)
    if isinstance(tree, bool):
        return f"whole[{j}] != 0", _Place(i, j + 1)
    if isinstance(tree, int):
        return f"whole[{j}]", _Place(i, j + 1)
    if not isinstance(tree, tuple):
        return f"numbers[{i}]", _Place(i + 1, j)
    kind = type(tree)
    imports.setdefault(kind.__module__, set()).add(written_name(kind))
    parts = []
    for part in tree:
        text, place = _expression(part, place, imports)
        parts.append(text)
    return f"{written_name(kind)}({', '.join(parts)})", place
