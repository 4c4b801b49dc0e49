"""Changes the numbers that modules name, one at a time, and says which changes no test notices (`make mutants`).

mutmut changes what stands in functions; thresholds are constants of modules, which it leaves alone. Each is made a quarter
smaller and a quarter larger, whole numbers by one at least, in a fork of this process that runs the module's own tests.

    python tools/constant_mutants.py [MODULE ...]      # such as measure.checks.clock; those of [tool.mutmut] if none is given
"""

import ast
import importlib
import os
import sys
import tomllib
from contextlib import redirect_stdout
from io import StringIO
from math import ceil, floor
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SRC = ROOT / "src" / "polydraulic"
OPTIONS = ["-x", "-q", "-m", "not slow", "-p", "no:cacheprovider"]


def modules() -> list[str]:
    """Modules that mutmut changes as well."""
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mutmut"]["only_mutate"]
    paths = [path.relative_to(SRC).with_suffix("") for pattern in patterns for path in sorted(ROOT.glob(pattern))]
    return [".".join(path.parts) for path in paths if path.name != "__init__"]


def constants(module: str) -> list[str]:
    """Names in capitals that the module itself gives a value, in its order."""
    tree = ast.parse((SRC / Path(*module.split("."))).with_suffix(".py").read_text())
    stored = [node for statement in tree.body if isinstance(statement, ast.Assign) for node in ast.walk(statement)]
    return [
        node.id
        for node in stored
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id.isupper()
    ]


def changed(value: object) -> list[object]:
    """Smaller and larger ones; of a tuple one of its numbers at a time."""
    if isinstance(value, tuple):
        return [(*value[:i], other, *value[i + 1 :]) for i, one in enumerate(value) for other in changed(one)]
    if isinstance(value, int) and not isinstance(value, bool):
        return [floor(0.75 * value) if value > 0 else value - 1, ceil(1.25 * value) if value > 0 else value + 1]
    return [0.75 * value, 1.25 * value] if isinstance(value, float) else []


def passes(tests: list[str], changes: dict[str, object]) -> bool:
    """Whether tests pass in a fork in which names have other values, in every module that has them."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    for name, (old, new) in changes.items():
        for module in [m for key, m in sys.modules.items() if key.startswith(("polydraulic", "tests"))]:
            if vars(module).get(name) is old:
                setattr(module, name, new)
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    os._exit(pytest.main([*OPTIONS, *tests]))


def main(chosen: list[str]) -> None:
    """Print what is noticed, module by module."""
    os.chdir(ROOT)
    for module in chosen or modules():
        *wings, name = module.split(".")
        tests = [str(Path("tests", *wings, f"test_{name}.py"))]
        loaded = importlib.import_module(f"polydraulic.{module}")
        mutants = [
            (key, getattr(loaded, key), other) for key in constants(module) for other in changed(getattr(loaded, key))
        ]
        with redirect_stdout(StringIO()) as said:
            passed = pytest.main([*OPTIONS, *tests]) == 0  # in this process: forks need not load anything again
        if not passed:
            print(said.getvalue())
            sys.exit(f"{tests[0]} fails as it is")
        survived = [(key, old, new) for key, old, new in mutants if passes(tests, {key: (old, new)})]
        print(f"{module}: {len(mutants)} changes of constants, {len(mutants) - len(survived)} noticed", flush=True)
        for key, old, new in survived:
            print(f"    {key} = {old} -> {new}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
