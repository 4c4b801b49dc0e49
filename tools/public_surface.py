"""Every public name with its signature, as text: ``make surface`` writes it to docs/public_surface.txt.

Signatures are those of the sources, so that the text does not depend on the version of Python. Where the text differs from the file,
a file in ``changes`` must name what has changed; otherwise nothing is written.
"""

import ast
import difflib
import importlib
import inspect
import re
import sys
import textwrap
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
FILE = ROOT / "docs" / "public_surface.txt"
PACKAGES = [
    "polydraulic",
    *(
        f"polydraulic.{name}"
        for name in "networks flow control watch measure identification export plotting gym".split()
    ),
]
SPECIAL = ("__init__", "__call__", "__getitem__", "__iter__", "__len__", "__contains__", "__eq__", "__str__")


def surface() -> str:
    """Return the public surface as text: a line a name, and one a member of a class."""
    lines = []
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in sorted(module.__all__):
            lines += [f"{package}.{line}" for line in _lines(name, getattr(module, name))]
    return "\n".join(lines) + "\n"


def changed(old: str, new: str) -> list[str]:
    """Public names, in order, of which a line was added, removed or changed: ``simulate``, ``Table.to_arrow``."""
    before, after = old.splitlines(), new.splitlines()
    differing = [line for line in [*before, *after] if (line in before) != (line in after)]
    names = [re.sub(r"^polydraulic\.(?:[a-z]+\.(?=\w))?", "", re.split(r"[(:\s]", line)[0]) for line in differing]
    return list(dict.fromkeys(names))


def unsaid(names: list[str], said: str) -> list[str]:
    """Those of the names that a text does not mention; of a member it may be the class or the member."""
    return [name for name in names if not any(re.search(rf"\b{part}\b", said) for part in name.split("."))]


def main() -> int:
    """Write the file, or say which changes are not said."""
    new, old = surface(), FILE.read_text() if FILE.exists() else ""
    said = "\n".join(path.read_text() for path in sorted((ROOT / "changes").glob("+*.md")))
    missing = unsaid(changed(old, new), said) if old else []
    if missing:
        print("\n".join(line for line in difflib.unified_diff(old.splitlines(), new.splitlines(), lineterm="", n=0)))
        print(f"changes/: no file says what has changed of {', '.join(missing)}; write one (changes/README.md)")
        return 1
    FILE.write_text(new)
    return 0


def _lines(name: str, thing: Any) -> list[str]:
    if inspect.isclass(thing):
        return _class_lines(name, thing)
    if inspect.isfunction(inspect.unwrap(thing)):
        return [name + _signature(_definition(inspect.unwrap(thing)))]
    if isinstance(thing, dict):
        return [f"{name}: {', '.join(map(str, thing))}"]
    return [f"{name}: {thing!r}"]


def _class_lines(name: str, cls: type) -> list[str]:
    """Bases, fields or constructor, and public members, those of the package's own base classes included."""
    own = [base for base in cls.__mro__ if base.__module__.startswith("polydraulic.")]  # itself first
    tree = _definition(cls)
    lines = [f"{name}({', '.join(ast.unparse(base) for base in tree.bases)})"]
    members: dict[str, list[str]] = {}
    for base in own:
        found: dict[str, list[str]] = {}
        for node in _definition(base).body:
            if isinstance(node, ast.AnnAssign) and not ast.unparse(node.target).startswith("_"):
                value = "" if node.value is None else f" = {ast.unparse(node.value)}"
                found[ast.unparse(node.target)] = [f": {ast.unparse(node.annotation)}{value}"]
            elif isinstance(node, ast.FunctionDef) and (node.name in SPECIAL or not node.name.startswith("_")):
                marks = [ast.unparse(mark) for mark in node.decorator_list]
                text = f" -> {ast.unparse(node.returns)}" if "property" in marks and node.returns else _signature(node)
                found.setdefault(node.name, []).append(text + (" classmethod" if "classmethod" in marks else ""))
        members = found | members  # those of the class itself come after, and win
    return [*lines, *(f"{name}.{member}{text}" for member in members for text in members[member])]


def _definition(thing: Any) -> Any:
    return ast.parse(textwrap.dedent(inspect.getsource(thing))).body[0]


def _signature(node: Any) -> str:
    return f"({ast.unparse(node.args)})" + ("" if node.returns is None else f" -> {ast.unparse(node.returns)}")


if __name__ == "__main__":
    sys.exit(main())
