"""Recorded terms as statements of Python, one per line: what has a name or is used twice is assigned, the rest stands in place."""

import re
from collections.abc import Callable, Iterable, Sequence

from polydraulic.machine.tree.terms import Term, TermNode

WIDTH = 120
_LONG = 80  # characters of an expression that is better assigned than put into another one
_INDENT = "    "


class Constants:
    """Fixed terms that functions read as fields of `constants`, in the order in which they were first asked for.

    Attributes
    ----------
    nodes : list of TermNode
        All of them have a name, which is that of the field.
    """

    def __init__(self) -> None:
        self.nodes: list[TermNode] = []

    def field(self, node: TermNode, owner: str) -> str:
        """Text that reads a fixed term; `owner` is the name of what it is a part of."""
        if node not in self.nodes:
            node.name = node.name or node.home.free_name(_own_name(node, f"{owner or 'result'}_fixed"))
            self.nodes.append(node)
        return f"constants.{node.name}"


def body(roots: Sequence[Term], result: Callable[[list[str]], str], constants: Constants | None = None) -> str:
    """Statements of a function.

    Parameters
    ----------
    roots : sequence of Term
        What the function gives.
    result : function
        Text of the expression that is returned, from the texts of the roots.
    constants : Constants, optional
        Takes the fixed terms; without it they are calculated here.
    """
    lines, texts = _written(roots, constants)
    return "\n".join([*lines, returned(result(texts))])


def stored(roots: Sequence[Term], places: Sequence[str], constants: Constants) -> str:
    """Statements of a function that writes terms into places of arrays; the other arguments are those of `body`."""
    lines, texts = _written(roots, constants)
    return "\n".join([*lines, *(f"{_INDENT}{place} = {text}" for place, text in zip(places, texts, strict=True))])


def _written(roots: Sequence[Term], constants: Constants | None) -> tuple[list[str], list[str]]:
    """Assignments with sections as comments, and the texts of the roots."""
    writer = _Writer(roots, constants)
    lines, section = [], ""
    for node, summands in writer.assigned.items():
        if constants is not None and node.section != section:
            section = node.section
            lines.append(f"{_INDENT}# {section}")
        lines.append(_assignment(node.name, summands))
    return lines, [writer.root(root) for root in roots]


def call(name: str, arguments: Sequence[str]) -> str:
    """Text of a call."""
    return f"{name}({', '.join(arguments)})"


def returned(text: str) -> str:
    """A return statement; the arguments of a call stand one per line where they need the room."""
    return _INDENT + _broken(f"return {text}", _INDENT)


def _broken(text: str, indent: str) -> str:
    if len(indent) + len(text) < WIDTH or not re.match(r"(return )?[A-Z]\w*\(.*\)$", text):
        return text
    start = text.index("(")
    deeper, arguments = indent + _INDENT, _split(text[start + 1 : -1])
    lines = "".join(f"{deeper}{_broken(argument, deeper)},\n" for argument in arguments)
    return f"{text[: start + 1]}\n{lines}{indent})"


def _split(text: str) -> list[str]:
    """Arguments of a call: parts between commas outside of brackets."""
    parts, depth = [""], 0
    for character in text:
        depth += {"(": 1, ")": -1}.get(character, 0)
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def _assignment(name: str, summands: list[str]) -> str:
    line = f"{_INDENT}{name} = {' '.join(summands)}"
    if len(line) <= WIDTH:
        return line
    inner = "\n".join(f"{_INDENT * 2}{summand}" for summand in summands)
    return f"{_INDENT}{name} = (\n{inner}\n{_INDENT})"


class _Writer:
    """Which nodes a function assigns, and the texts of all.

    Attributes
    ----------
    assigned : dict from TermNode to list of str
        The right side of each assignment, parts of a sum apart, each with its sign but the first.
    """

    def __init__(self, roots: Sequence[Term], constants: Constants | None) -> None:
        self._constants = constants
        self.assigned: dict[TermNode, list[str]] = {}
        uses, owners = self._uses([root.node for root in roots if root.node is not None])
        # sums that are written as parts of another one, however long they are
        within = {part for node in uses if node.kind == "sum" for part, factor in node.parts if abs(factor) == 1.0}
        self._owners = owners
        for node in sorted(uses, key=lambda node: node.order):
            if self._is_constant(node):
                continue
            if node.kind == "leaf":
                # read by other means than its name, before a run
                if node.fixed and node.parts[0] != node.name:
                    self.assigned[node] = [node.parts[0]]
                continue
            summands = self._summands(node)
            long = node not in within and len(" ".join(summands)) > _LONG
            if node.name or uses[node] > 1 or long:
                node.name = node.name or node.home.free_name(_own_name(node, f"{owners[node] or 'result'}_part"))
                self.assigned[node] = summands

    def _uses(self, roots: list[TermNode]) -> tuple[dict[TermNode, int], dict[TermNode, str]]:
        """How often each node is used, and the name of what it is a part of."""
        uses: dict[TermNode, int] = {}
        for root in roots:
            uses[root] = uses.get(root, 0) + 1
        seen, waiting = set(), list(roots)
        while waiting:
            node = waiting.pop()
            if node in seen or self._is_constant(node):
                continue
            seen.add(node)
            for part in _below(node):
                uses[part] = uses.get(part, 0) + 1
                waiting.append(part)
        owners: dict[TermNode, str] = {}
        for node in sorted(seen, key=lambda node: -node.order):
            owners.setdefault(node, "")
            for part in _below(node):
                owners[part] = node.name or owners[node]
        return uses, owners

    def _is_constant(self, node: TermNode) -> bool:
        return node.fixed and self._constants is not None

    def root(self, term: Term) -> str:
        """Text of what is returned."""
        return repr(term.factor) if term.node is None else self._scaled(term.node, term.factor)

    def _summands(self, node: TermNode) -> list[str]:
        if node.kind != "sum":
            return [self._whole(node)]
        # what is known first is added first, so that the processor waits for the last part alone
        signed = [(sign, text) for _, sign, text in sorted(self._signed(node, 1.0), key=lambda part: part[0])]
        first = next((i for i, (sign, _) in enumerate(signed) if sign > 0.0), 0)  # rather a - b than -b + a
        signed.insert(0, signed.pop(first))
        return [
            ("" if i == 0 else "+ ") + text if sign > 0.0 else ("-" if i == 0 else "- ") + text
            for i, (sign, text) in enumerate(signed)
        ]

    def _signed(self, node: TermNode, sign: float) -> list[tuple[tuple[int, int], float, str]]:
        """Parts of a sum: when they are known, signs and texts; sums that stand in its place are taken apart."""
        found = []
        for part, factor in node.parts:
            if abs(factor) == 1.0 and part.kind == "sum" and len(part.parts) > 1 and self._stands_here(part):
                found += self._signed(part, sign * factor)
            else:
                text = self._scaled(part, abs(factor))
                found.append(((part.depth, part.order), sign if factor > 0.0 else -sign, text))
        return found

    def _stands_here(self, node: TermNode) -> bool:
        return node not in self.assigned and not self._is_constant(node)

    def _whole(self, node: TermNode) -> str:
        """Text of what a node is made of."""
        if node.kind == "sum":
            return " ".join(self._summands(node))
        if node.kind == "product":
            return " * ".join(self._factor(part) for part in node.parts)
        if node.kind == "reciprocal":
            return f"1.0 / {self._factor(node.parts[0], divisor=True)}"
        return str(node.parts[0])

    def _text(self, node: TermNode) -> str:
        """Text of a node where it is used."""
        if node.fixed and self._constants is not None:
            return self._constants.field(node, self._owners.get(node, ""))
        return node.name if node in self.assigned else self._whole(node)

    def _factor(self, node: TermNode, *, divisor: bool = False) -> str:
        loose = node.kind in ("sum", "reciprocal") or (divisor and node.kind == "product")
        return f"({self._text(node)})" if loose and self._stands_here(node) else self._text(node)

    def _scaled(self, node: TermNode, factor: float) -> str:
        if factor == 1.0:
            return self._text(node)
        return f"-{self._factor(node)}" if factor == -1.0 else f"{factor!r} * {self._factor(node)}"


def _below(node: TermNode) -> Iterable[TermNode]:
    return [part for part, _ in node.parts] if node.kind == "sum" else [] if node.kind == "leaf" else node.parts


def _own_name(node: TermNode, otherwise: str) -> str:
    """A name for what has none, made of the names of its parts where all have one."""
    if node.kind == "sum" and len(node.parts) == 1 and node.parts[0][0].name:
        ((part, factor),) = node.parts
        return f"{ {2.0: 'twice', 0.5: 'half'}.get(factor, 'scaled') }_{part.name}"
    if node.kind == "product" and all(part.name for part in node.parts):
        names = [part.name for part in node.parts]
        powers = {name: names.count(name) for name in names}
        joined = "_times_".join(
            name if power == 1 else f"{name}_squared" if power == 2 else f"{name}_power_{power}"
            for name, power in powers.items()
        )
        return joined if len(joined) < 60 else otherwise
    return otherwise
