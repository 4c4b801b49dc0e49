"""Where the variables of a function occur, which says where C must declare them; and its comments."""

import ast
import io
import textwrap
import tokenize
from dataclasses import dataclass, field


@dataclass
class Use:
    """How a variable occurs in a function."""

    times_assigned: int = 0
    paths: list[tuple[tuple[int, int], ...]] = field(default_factory=list)  # (block, statement) from outside in

    def home(self) -> tuple[int, int]:
        """Innermost block that holds all occurrences, and its first statement that does."""
        depth, one = 0, self.paths[0]
        while all(path[: depth + 1] == one[: depth + 1] and len(path) > depth + 1 for path in self.paths):
            if len({path[depth + 1][0] for path in self.paths}) > 1:
                break
            depth += 1
        return one[depth][0], min(path[depth][1] for path in self.paths)


def find_uses(body: list[ast.stmt]) -> dict[str, Use]:
    """Occurrences of all names that are assigned in a function."""
    nodes = [node for part in body for node in ast.walk(part) if isinstance(node, ast.Name)]
    uses = {node.id: Use() for node in nodes if isinstance(node.ctx, ast.Store)}

    def descend(body: list[ast.stmt], path: tuple[tuple[int, int], ...]) -> None:
        for number, statement in enumerate(body):
            here = (*path, (id(body), number))
            inner = {id(node) for block in _blocks(statement) for part in block for node in ast.walk(part)}
            for node in ast.walk(statement):
                if isinstance(node, ast.Name) and node.id in uses and id(node) not in inner:
                    uses[node.id].times_assigned += isinstance(node.ctx, ast.Store)
                    uses[node.id].paths.append(here)
            for block in _blocks(statement):
                descend(block, here)

    descend(body, ())
    return uses


def _blocks(s: ast.stmt) -> list[list[ast.stmt]]:
    """Blocks inside a statement; those of an elif belong to its if."""
    if isinstance(s, ast.If):
        last = _blocks(s.orelse[0]) if is_elif(s.orelse) else [s.orelse]
        return [block for block in (s.body, *last) if block]
    return [s.body] if isinstance(s, ast.For | ast.While) else []


def is_elif(orelse: list[ast.stmt]) -> bool:
    """Whether an else holds nothing but another if."""
    return len(orelse) == 1 and isinstance(orelse[0], ast.If)


def comments_of(source: str, first: int) -> dict[int, str]:
    """Comments by line; notes for tools are left out."""
    found = {}
    for token in tokenize.generate_tokens(io.StringIO(textwrap.dedent(source)).readline):
        text = token.string.lstrip("# ").rstrip()
        if token.type == tokenize.COMMENT and not text.startswith(("fmt:", "type:", "noqa")):
            found[token.start[0] + first - 1] = text
    return found
