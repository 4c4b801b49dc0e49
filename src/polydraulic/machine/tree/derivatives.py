"""Derivatives of recorded terms, recorded: exact, and folded and shared like what they are derived from."""

from collections.abc import Iterable, Mapping

from polydraulic.machine.tree.terms import ZERO, Recorder, Term, TermNode


def derivatives(terms: Iterable[Term], by: Mapping[TermNode, Term]) -> list[Term]:
    """Derivative of each term along one direction.

    Parameters
    ----------
    terms : iterable of Term
    by : mapping from leaf to Term
        Derivatives of the leaves along that direction; all others stay.
    """
    wanted = list(terms)
    known: dict[TermNode, Term] = {}
    for node in sorted(_moving(term.node for term in wanted), key=lambda node: node.order):
        known[node] = _derivative(node, known, by)
    return [_scaled(term, known) for term in wanted]


def _moving(nodes: Iterable[TermNode | None]) -> set[TermNode]:
    """All that the nodes are made of and that is not fixed."""
    found: set[TermNode] = set()
    waiting = list(nodes)
    while waiting:
        node = waiting.pop()
        if node is None or node.fixed or node in found:
            continue
        found.add(node)
        if node.kind == "sum":
            waiting += [part for part, _ in node.parts]
        elif node.kind != "leaf":
            waiting += node.parts
    return found


def _derivative(node: TermNode, known: Mapping[TermNode, Term], by: Mapping[TermNode, Term]) -> Term:
    if node.kind == "leaf":
        return by.get(node, ZERO)
    if node.kind == "sum":
        return sum((_scaled(Term(factor, part), known) for part, factor in node.parts), ZERO)
    if node.kind == "product":
        first, second = (Term(1.0, part) for part in node.parts)
        return _scaled(first, known) * second + first * _scaled(second, known)
    (part,) = node.parts
    whole = Term(1.0, node)
    return -(_scaled(Term(1.0, part), known) * whole * whole)


def _scaled(term: Term, known: Mapping[TermNode, Term]) -> Term:
    if term.node is None or term.node.fixed:
        return ZERO
    return known[term.node] * term.factor


def along_joint(terms: Recorder, name: str, *, turns: bool) -> dict[TermNode, Term]:
    """What changes with the position of a joint, read as fields of `turn`: derivatives of its leaves."""
    if not turns:
        way = terms.leaf(f"turn.{name}", f"{name}_way")
        return {_node(way): Term(1.0, None)}
    sin, cos = (terms.leaf(f"turn.{name}.{part}", f"{name}_{part}") for part in ("sin", "cos"))
    return {_node(sin): cos, _node(cos): -sin}


def along_rate(terms: Recorder, name: str) -> dict[TermNode, Term]:
    """What changes with the rate of a joint."""
    return {_node(terms.leaf(f"rate.{name}", f"{name}_rate")): Term(1.0, None)}


def _node(leaf: Term) -> TermNode:
    assert leaf.node is not None
    return leaf.node
