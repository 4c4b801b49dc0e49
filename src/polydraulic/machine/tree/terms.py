"""Arithmetic that is recorded instead of done: what is zero is left out, what occurs twice is shared, what is fixed stays apart.

A term is a number times a node. A node is a leaf, a sum, a product or a reciprocal; two nodes of the same content are the same
node. Nodes made of parameters alone are fixed: they can be computed before a run, so that a product of a fixed
factor and a factor that moves holds one fixed factor, and a sum one fixed part.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any


@dataclass(eq=False)
class TermNode:
    """Something that is computed once.

    Attributes
    ----------
    home : Recorder
    order : int
        Nodes are numbered as they are made, so that parts come before wholes.
    kind : "leaf", "sum", "product" or "reciprocal"
    parts : tuple
        Of a sum pairs (node, factor), of a product and a reciprocal nodes, of a leaf its text.
    fixed : bool
        Whether it is made of parameters alone.
    section : str
        What was recorded when it was made.
    depth : int
        Operations one after the other until it is known, if nothing else keeps the processor busy.
    name : str
        For the text; may be empty.
    """

    home: "Recorder"
    order: int
    kind: str
    parts: tuple[Any, ...]
    fixed: bool
    section: str
    depth: int
    name: str = ""


@dataclass(frozen=True)
class Term:
    """`factor` times `node`, or the number `factor` where there is no node."""

    factor: float
    node: TermNode | None

    @property
    def zero(self) -> bool:
        """Whether it is zero by structure."""
        return self.factor == 0.0

    @property
    def fixed(self) -> bool:
        """Whether it is made of parameters and numbers alone."""
        return self.node is None or self.node.fixed

    def __add__(self, other: "Term | float") -> "Term":
        return _added(self, _term(other))

    __radd__ = __add__

    def __sub__(self, other: "Term | float") -> "Term":
        return _added(self, -_term(other))

    def __rsub__(self, other: "Term | float") -> "Term":
        return _added(_term(other), -self)

    def __mul__(self, other: "Term | float") -> "Term":
        return _multiplied(self, _term(other))

    __rmul__ = __mul__

    def __neg__(self) -> "Term":
        return ZERO if self.zero else Term(-self.factor, self.node)

    def named(self, name: str) -> "Term":
        """The same, called `name` in the text unless it has a name already, or is named as what it is the negative of."""
        node = self.node
        if node is not None and node.kind != "leaf" and not node.name and abs(self.factor) == 1.0:
            node.name = node.home.free_name(name if self.factor > 0.0 else f"minus_{name}")
        return self


ZERO = Term(0.0, None)


def _term(value: Term | float) -> Term:
    if isinstance(value, Term):
        return value
    return Term(value, None) if value != 0.0 else ZERO


@dataclass
class Recorder:
    """All nodes of one text, and the names that they have.

    Attributes
    ----------
    section : str
        What is recorded at present; a comment in the text.
    """

    section: str = ""
    _known: dict[tuple[Any, ...], TermNode] = field(default_factory=dict)
    _names: set[str] = field(default_factory=set)

    def leaf(self, text: str, name: str, *, fixed: bool = False) -> Term:
        """Something that is there already, `text` in the text; `name` is what it is called in other names."""
        node = self.node("leaf", (text,), fixed)
        node.name = node.name or self.free_name(name)
        return Term(1.0, node)

    def reciprocal(self, term: Term) -> Term:
        """1 / term, where the term moves."""
        assert term.node is not None
        return Term(1.0 / term.factor, self.node("reciprocal", (term.node,), term.fixed))

    def free_name(self, name: str) -> str:
        """`name`, or the same with a number where it is taken; it is taken from now on."""
        found, number = name, 2
        while found in self._names:
            found, number = f"{name}_{number}", number + 1
        self._names.add(found)
        return found

    def node(self, kind: str, parts: tuple[Any, ...], fixed: bool) -> TermNode:
        """The node of this content."""
        key = (kind, parts)
        if key not in self._known:
            depth = 0 if fixed or kind == "leaf" else 1 + max(part.depth for part in parts)
            self._known[key] = TermNode(self, len(self._known), kind, parts, fixed, self.section, depth)
        return self._known[key]

    def sum_node(self, parts: dict[TermNode, float], *, fixed: bool) -> Term:
        """The sum of these parts, in the order of their making.

        A sum and its negative are one node, with the signs of the one that was made first, unless all of these are negative.
        """
        ordered = tuple(sorted(parts.items(), key=lambda part: part[0].order))
        sign = 1.0 if ordered[0][1] > 0.0 else -1.0
        key = ("sum", tuple((node, factor * sign) for node, factor in ordered))
        if key not in self._known:
            shown = ordered if any(factor > 0.0 for _, factor in ordered) else key[1]
            depth = 0
            if not fixed:
                for known in sorted(node.depth for node in parts):
                    depth = 1 + max(depth, known)
            self._known[key] = TermNode(self, len(self._known), "sum", shown, fixed, self.section, depth)
        node = self._known[key]
        return Term(1.0 if node.parts[0][1] == ordered[0][1] else -1.0, node)


def _added(a: Term, b: Term) -> Term:
    if a.zero or b.zero:
        return b if a.zero else a
    if a.node is None or b.node is None:
        if a.node is b.node:
            return _term(a.factor + b.factor)
        raise TypeError("a number without unit is added to a quantity")
    if a.fixed and b.fixed:
        left, right = _all_parts(a), _all_parts(b)
        return _sum({n: left.get(n, 0.0) + right.get(n, 0.0) for n in [*left, *right]})
    # as little as possible is taken apart: only where parts meet their like, and a fixed part a fixed one
    for left in (_single(a), _parts(a)):
        for right in (_single(b), _parts(b)):
            if left.keys() & right.keys():
                return _sum(_settled({n: left.get(n, 0.0) + right.get(n, 0.0) for n in [*left, *right]}))
    for one, other in ((a, b), (b, a)):
        if one.fixed and not other.fixed and (found := _with_fixed(other, one)) is not None:
            return found
    return _sum(_single(a) | _single(b))


def _settled(parts: dict[TermNode, float]) -> dict[TermNode, float]:
    """The same with sums taken apart that hold the like of another part."""
    for whole, factor in parts.items():
        inner = _parts(Term(factor, whole)) if whole.kind == "sum" and factor != 0.0 else {}
        if any(parts.get(node, 0.0) != 0.0 for node in inner):
            rest = {node: size for node, size in parts.items() if node is not whole}
            return _settled({n: rest.get(n, 0.0) + inner.get(n, 0.0) for n in [*rest, *inner]})
    return parts


def _with_fixed(total: Term, fixed: Term) -> Term | None:
    """The sum of both if `total` has a fixed part somewhere, which takes the other; else None."""
    parts = _parts(total)
    if any(node.fixed for node in parts):
        return _sum(parts | _single(fixed))
    for node, factor in parts.items():
        if node.kind == "sum" and node is not total.node and not node.name and abs(factor) == 1.0:
            found = _with_fixed(Term(factor, node), fixed)
            if found is not None and found.node is not None:
                rest = {other: size for other, size in parts.items() if other is not node}
                return _sum(rest) + found
    return None


def _single(term: Term) -> dict[TermNode, float]:
    assert term.node is not None
    return {term.node: term.factor}


def _parts(term: Term) -> dict[TermNode, float]:
    """A sum as its parts."""
    assert term.node is not None
    if term.node.kind != "sum":
        return _single(term)
    return {node: factor * term.factor for node, factor in term.node.parts}


def _all_parts(term: Term) -> dict[TermNode, float]:
    """A sum as its parts, those as theirs, and so on down to what has a name."""
    if term.node is not None and (term.node.name or term.node.kind != "sum"):
        return _single(term)
    found: dict[TermNode, float] = {}
    for node, factor in _parts(term).items():
        for part, times in _all_parts(Term(factor, node)).items():
            found[part] = found.get(part, 0.0) + times
    return found


def _sum(parts: dict[TermNode, float]) -> Term:
    parts = {node: factor for node, factor in parts.items() if factor != 0.0}
    if not parts:
        return ZERO
    home = next(iter(parts)).home
    all_fixed = all(node.fixed for node in parts)
    if not all_fixed:
        fixed = {node: factor for node, factor in parts.items() if node.fixed}
        term = _sum(fixed) if fixed else ZERO
        moving = [(node, factor) for node, factor in parts.items() if not node.fixed]
        parts = {}
        for node, factor in [*moving, *([] if term.node is None else [(term.node, term.factor)])]:
            node, factor = _folded(node, factor)
            parts[node] = parts.get(node, 0.0) + factor
    if len(parts) == 1:
        ((node, factor),) = parts.items()
        return Term(factor, node)
    sizes = {abs(factor) for factor in parts.values()}
    size = sizes.pop() if len(sizes) == 1 else 1.0
    return home.sum_node({node: factor / size for node, factor in parts.items()}, fixed=all_fixed) * size


def _folded(node: TermNode, factor: float) -> tuple[TermNode, float]:
    """The same with a factor of 1 or -1 where the node has a fixed part that takes the rest."""
    size, sign = abs(factor), 1.0 if factor > 0.0 else -1.0
    if size == 1.0:
        return node, sign
    if node.fixed:
        scaled = node.home.sum_node({node: size}, fixed=True).node
        assert scaled is not None
        return scaled, sign
    if node.kind == "product" and node.parts[0].fixed:
        return node.home.node("product", (_folded(node.parts[0], size)[0], node.parts[1]), fixed=False), sign
    return node, factor


def _multiplied(a: Term, b: Term) -> Term:
    factor = a.factor * b.factor
    if factor == 0.0:
        return ZERO
    if a.node is None or b.node is None:
        return Term(factor, b.node if a.node is None else a.node)
    home = a.node.home
    if a.fixed and b.fixed:
        factors = [*_factors(a.node), *_factors(b.node)]
        return Term(factor, home.node("product", tuple(sorted(factors, key=lambda node: node.order)), fixed=True))
    if a.fixed or b.fixed:
        fixed, moving = (a.node, b.node) if a.fixed else (b.node, a.node)
        if moving.kind == "product" and moving.parts[0].fixed:
            (fixed, moving), scale = _fixed_first(fixed, moving)
            factor *= scale
        node, sign = _folded(fixed, factor)
        return Term(sign, home.node("product", (node, moving), fixed=False))
    return Term(factor, home.node("product", tuple(sorted((a.node, b.node), key=lambda node: node.order)), fixed=False))


def _fixed_first(fixed: TermNode, moving: TermNode) -> tuple[tuple[TermNode, TermNode], float]:
    """One fixed factor of two, and what it is multiplied by."""
    product = _multiplied(Term(1.0, fixed), Term(1.0, moving.parts[0]))
    assert product.node is not None
    return (product.node, moving.parts[1]), product.factor


def _factors(node: TermNode) -> Iterable[TermNode]:
    return node.parts if node.kind == "product" else (node,)
