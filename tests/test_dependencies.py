"""What is imported is declared, where it is used; the package itself needs no extra to be imported."""

import ast
import importlib
import importlib.util
import re
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]
OWN = {
    "polydraulic",
    "helpers",
    *(path.stem for folder in ("benchmarks", "tools") for path in (ROOT / folder).rglob("*.py")),
}
MODULES = {"sksundae": "scikit-sundae", "pyearth": "py-earth2"}  # peers of the benchmarks, seldom installed


def _bare(requirement):
    return re.split(r"[\[<>=!~; ]", requirement, maxsplit=1)[0].lower().replace("_", "-")


def _declared(*lists):
    return {_bare(requirement) for requirements in lists for requirement in requirements}


CORE = _declared(PROJECT["dependencies"])
PEERS = _declared((ROOT / "benchmarks/peers/requirements.txt").read_text().splitlines())
ALL = CORE | _declared(*EXTRAS.values())


def _imports(tree):
    """Top-level names of absolute imports below a node of the syntax tree."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.partition(".")[0]


@cache
def _distributions():
    """Distributions by the names that they install; reading what all of them say takes a second."""
    return packages_distributions()


def _undeclared(names, declared):
    known = _distributions()
    foreign = sorted(set(names) - set(sys.stdlib_module_names) - OWN)
    homes = {name: {_bare(home) for home in known.get(name, [MODULES.get(name, name)])} for name in foreign}
    return [name for name, home in homes.items() if not home & declared]


@cache
def _trees(*folders):
    paths = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    assert paths
    return [ast.parse(path.read_text()) for path in paths]


def test_the_package_imports_what_is_declared():
    assert _undeclared([name for tree in _trees("src") for name in _imports(tree)], ALL) == []


BASES = {"gym": "gymnasium"}  # folders whose classes are those of an extra's, and nobody else imports them


def test_outside_of_functions_the_package_imports_the_core_alone():
    def at_import(tree):
        for node in ast.iter_child_nodes(tree):
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                continue
            if isinstance(node, ast.Import | ast.ImportFrom):
                yield from _imports(ast.Module([node], []))
            elif not isinstance(node, ast.FunctionDef):
                yield from at_import(node)

    source = ROOT / "src" / "polydraulic"
    for path in source.rglob("*.py"):
        allowed = CORE | {BASES.get(path.relative_to(source).parts[0], "")}
        assert _undeclared(at_import(ast.parse(path.read_text())), allowed) == [], path


@pytest.mark.parametrize(("folder", "declared"), [("tests", ALL), ("examples", ALL), ("docs", ALL), ("tools", ALL)])
def test_what_is_around_the_package_imports_what_is_declared(folder, declared):
    assert _undeclared([name for tree in _trees(folder) for name in _imports(tree)], declared) == []


def test_benchmarks_import_what_is_declared():
    assert _undeclared([name for tree in _trees("benchmarks") for name in _imports(tree)], ALL | PEERS) == []


@pytest.mark.parametrize("folder", ["benchmarks", "examples", "tools"])
def test_what_is_taken_from_the_package_is_there(folder):
    """Benchmarks run for hours, and seldom: a name that has gone would stop them half-way."""
    taken = {
        (node.module, alias.name)
        for tree in _trees(folder)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module.partition(".")[0] == "polydraulic"
        for alias in node.names
    }

    def there(module, name):
        return hasattr(importlib.import_module(module), name) or importlib.util.find_spec(f"{module}.{name}")

    assert [names for names in sorted(taken) if not there(*names)] == []


def test_every_dependency_is_used():
    names = {name for tree in _trees("src") for name in _imports(tree)}
    known = _distributions()
    used = {_bare(home) for name in names for home in known.get(name, [name])}
    assert CORE - used == set()


def test_all_holds_what_tests_and_rules_need():
    together = set(re.findall(r"[\w]+", EXTRAS["all"][0].partition("[")[2]))
    assert together >= {"export", "measure", "test", "lint", "docs", "release"}
