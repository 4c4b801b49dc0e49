"""Nested named tuples come back from two arrays as they were, whatever they hold."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic.simulation.stepping.packed import pack_tree, unpack_text


class Inner(NamedTuple):
    """Some of each kind."""

    table: np.ndarray
    number: float
    holds: bool
    steps: np.ndarray
    count: int


class Outer(NamedTuple):
    """Parts of parts."""

    first: Inner
    value: float
    second: Inner


def inner(rng, n):
    return Inner(
        rng.normal(size=(n, 3, 2)), float(rng.normal()), bool(n % 2), rng.integers(-9, 9, n), int(rng.integers(99))
    )


def same(a: Any, b: Any) -> bool:
    if isinstance(a, tuple):
        return type(a) is type(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return bool(np.array_equal(a, b)) and np.shape(a) == np.shape(b)


def test_what_is_packed_comes_back():
    rng = np.random.default_rng(0)
    trees = {"left": Outer(inner(rng, 4), 2.5, inner(rng, 0)), "right": inner(rng, 3)}
    packed, names = pack_tree(tuple(trees.values())), {"kernel": lambda f: f, "np": np}
    assert (packed.numbers.dtype, packed.whole.dtype) == (np.float64, np.int64)
    exec(unpack_text(trees), names)  # plain Python
    for name, tree in trees.items():
        assert same(names[f"unpack_{name}"](packed.numbers, packed.whole), tree)


def test_the_text_depends_on_types_alone():
    rng = np.random.default_rng(1)
    assert unpack_text({"x": inner(rng, 4)}) == unpack_text({"x": inner(rng, 7)})
