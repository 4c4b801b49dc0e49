"""Pages written for all layouts -> text for one: what a page says of every function is written out function by function.

A page is Python in which single capital letters stand for what a layout has. Three forms are written out:

- ``for F, A in FUNCTIONS:`` in front of statements, or of fields of a class;
- ``*[... for F in FUNCTIONS]`` among arguments;
- ``any([... for F in FUNCTIONS])`` and ``all([...])``: conditions joined by ``or`` and ``and``.

Inside them a letter that is a name, or a part of one between underscores, is replaced: with F = boom, ``x.F`` is ``x.boom`` and
``k_F`` is ``k_boom``. A letter whose value is a number is that number. Names of lists are replaced as well, so that loops may be nested:
``FUNCTIONS_OF_C``.
"""

import ast
import re
from collections.abc import Mapping, Sequence
from typing import Any

Value = str | int
Rows = Sequence[Mapping[str, Value]]
WIDTH = 116  # of a line, before it is broken


def expanded(page: str, lists: Mapping[str, Rows], names: Mapping[str, Value] | None = None) -> str:
    """Write a page out.

    Parameters
    ----------
    page : str
    lists : mapping from the name of a list to its rows, each a mapping from letter to name or number
    names : mapping, optional
        Letters and constants that are replaced everywhere.

    Returns
    -------
    str
        Python source; comments of the page are not in it, docstrings are.

    Raises
    ------
    ValueError
        A letter or a list that the page uses and nobody gives.
    """
    tree = _Writer(lists, names or {}).visit(ast.parse(page))
    ast.fix_missing_locations(tree)
    return "\n\n\n".join(_text(node) for node in tree.body) + "\n"


class _Writer(ast.NodeTransformer):
    def __init__(self, lists: Mapping[str, Rows], letters: Mapping[str, Value]) -> None:
        self._lists, self._letters = lists, letters

    def _with(self, letters: Mapping[str, Value]) -> "_Writer":
        return _Writer(self._lists, {**self._letters, **letters})

    def _name(self, name: str) -> str:
        parts = name.split("_")
        return "_".join(str(self._letters.get(part, part)) for part in parts)

    def _rows(self, target: ast.expr, source: ast.expr) -> list["_Writer"] | None:
        """A writer for each row of a list, None if this is an ordinary loop."""
        if not isinstance(source, ast.Name) or (not source.id.isupper() and not source.id.split("_")[0].isupper()):
            return None
        name = self._name(source.id)
        wanted = [node.id for node in ast.walk(target) if isinstance(node, ast.Name)]
        if name not in self._lists:
            raise ValueError(f"a page loops over {name}; there are {sorted(self._lists)}")
        rows = self._lists[name]
        if rows and not set(wanted) <= set(rows[0]):
            raise ValueError(f"{name} gives {sorted(rows[0])}, the page wants {wanted}")
        return [self._with({letter: row[letter] for letter in wanted}) for row in rows]

    def visit_Name(self, node: ast.Name) -> ast.expr:
        value = self._letters.get(node.id)
        if isinstance(value, int):
            return ast.Constant(value)
        return ast.Name(self._name(node.id), node.ctx)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return ast.Attribute(self.visit(node.value), self._name(node.attr), node.ctx)

    def visit_arg(self, node: ast.arg) -> ast.arg:
        return ast.arg(self._name(node.arg), self.visit(node.annotation) if node.annotation else None)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        self.generic_visit(node)
        node.name = self._name(node.name)
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.ClassDef:
        self.generic_visit(node)
        node.name = self._name(node.name)
        return node

    def visit_For(self, node: ast.For) -> Any:
        rows = self._rows(node.target, node.iter)
        if rows is None:
            return self.generic_visit(node)
        found: list[ast.stmt] = []
        for row in rows:
            for statement in node.body:
                done = row.visit(_copy(statement))
                found += done if isinstance(done, list) else [done]
        return found

    def visit_Starred(self, node: ast.Starred) -> Any:
        written = self._written(node.value)
        return self.generic_visit(node) if written is None else written

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if isinstance(node.func, ast.Name) and node.func.id in ("any", "all") and len(node.args) == 1:
            written = self._written(node.args[0])
            if written is not None:
                return (
                    written[0]
                    if len(written) == 1
                    else ast.BoolOp(ast.Or() if node.func.id == "any" else ast.And(), written)
                )
        self.generic_visit(node)
        return node

    def _written(self, node: ast.expr) -> list[ast.expr] | None:
        """The elements of ``[... for F in FUNCTIONS]``."""
        if not isinstance(node, ast.ListComp) or len(node.generators) != 1:
            return None
        loop = node.generators[0]
        rows = self._rows(loop.target, loop.iter)
        return None if rows is None else [row.visit(_copy(node.elt)) for row in rows]


def _copy(node: Any) -> Any:
    return (
        ast.parse(ast.unparse(node)).body[0]
        if isinstance(node, ast.stmt)
        else ast.parse(ast.unparse(node), mode="eval").body
    )


def _text(node: ast.stmt) -> str:
    """Source of a top-level statement; calls, definitions and conditions that are too long for a line broken into their parts."""
    return "\n".join(part for line in ast.unparse(node).split("\n") for part in _broken(line))


def _broken(line: str) -> list[str]:
    """A line that is too long as several: one part of what is outermost in it per line, each broken again if need be."""
    if len(line) <= WIDTH:
        return [line]
    return _broken_call(line) or _broken_condition(line) or [line]


def _broken_call(line: str) -> list[str]:
    """One argument of a call, or of a definition, per line; nothing if the line is neither."""
    indent = line[: len(line) - len(line.lstrip())]
    start = re.match(r"\s*(?:return |def |[\w, .]+ = )?[\w.]+\(", line)
    end = re.search(r"\)(?:,| -> [\w.]+:)?$", line)
    if start is None or end is None:
        return []
    parts = _parts(line[start.end() : end.start()], ",")
    lines = [piece for part in parts for piece in _broken(f"{indent}    {part.strip()},")]
    return [line[: start.end()], *lines, f"{indent}{end[0]}"] if parts else []


def _broken_condition(line: str) -> list[str]:
    """One condition of several that are joined per line; nothing if there are none."""
    found = re.match(r"(\s*)(return |if |\w+ = )(.*?)(:?)$", line)
    if found is None:
        return []
    indent, head, inside, tail = found.groups()
    for word in (" or ", " and "):
        parts = _parts(inside, word)
        if len(parts) > 1 and not any(len(_parts(inside, other)) > 1 for other in (" if ", ", ")):
            joined = [parts[0], *(f"{word.strip()} {part}" for part in parts[1:])]
            return [f"{indent}{head}(", *(f"{indent}    {part}" for part in joined), f"{indent}){tail}"]
    return []


def _parts(text: str, between: str) -> list[str]:
    """Parts of a text between separators outside of brackets; none if a bracket closes that was not opened."""
    depth, begin, found = 0, 0, []
    for place, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if depth < 0:
            return []
        if depth == 0 and text.startswith(between, place):
            found.append(text[begin:place])
            begin = place + len(between)
    return [*found, text[begin:]]
