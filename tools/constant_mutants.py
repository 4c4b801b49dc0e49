"""Changes the numbers that modules name, one at a time, and says which changes no test notices (`make mutants`).

mutmut changes what stands in functions; thresholds are constants of modules, which it leaves alone. Each is made a quarter
smaller and a quarter larger, whole numbers by one at least, in a fork of this process that runs the module's own tests; of a
module without tests of its own those of its folder. Changes that go on for much longer than the tests do are noticed by that.
A constant that can be taken away unnoticed is covered by none of these tests. Nothing is written into the tree.

    python tools/constant_mutants.py [MODULE ...]      # such as measure.checks.clock; those of [tool.mutmut] if none is given
"""

import ast
import importlib
import os
import signal
import sys
import tempfile
import tomllib
from collections import Counter
from contextlib import redirect_stdout
from io import StringIO
from math import ceil, floor
from pathlib import Path
from time import process_time
from types import FunctionType, ModuleType

import pytest

ROOT = Path(__file__).parents[1]
SRC = ROOT / "src" / "polydraulic"
OPTIONS = ["-x", "-q", "-m", "not slow", "-p", "no:cacheprovider"]
OUTCOMES = ("killed", "survived", "not covered")
REMOVED = object()


def source_of(module: str) -> Path:
    """Its file."""
    return (SRC / Path(*module.split("."))).with_suffix(".py")


def modules(chosen: list[str]) -> list[str]:
    """Those chosen, or if none is the modules that mutmut changes as well."""
    if missing := [module for module in chosen if not source_of(module).is_file()]:
        sys.exit(f"there is no module {missing[0]}; name one such as measure.checks.clock")
    if chosen:
        return chosen
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mutmut"]["only_mutate"]
    paths = [path.relative_to(SRC).with_suffix("") for pattern in patterns for path in sorted(ROOT.glob(pattern))]
    return [".".join(path.parts) for path in paths if path.name != "__init__"]


def tests_of(module: str) -> list[str]:
    """Its own tests, or those of its folder."""
    *wings, name = module.split(".")
    folder = Path("tests", *wings)
    own = folder / f"test_{name}.py"
    return [str(path) for path in ([own] if own.exists() else sorted(folder.glob("test_*.py")))]


def constants(module: str) -> list[str]:
    """Names in capitals that the module itself gives a value, in its order."""
    tree = ast.parse(source_of(module).read_text())
    stored = [node for one in tree.body if isinstance(one, ast.Assign | ast.AnnAssign) for node in ast.walk(one)]
    return [
        node.id
        for node in stored
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id.isupper()
    ]


def changed(value: object) -> list[tuple[str, object]]:
    """Smaller and larger ones, with what becomes of what; of a tuple or a dictionary one of its numbers at a time."""
    if isinstance(value, tuple):
        parts = [(i, words, other) for i, one in enumerate(value) for words, other in changed(one)]
        return [(f"[{i}]{words}", (*value[:i], other, *value[i + 1 :])) for i, words, other in parts]
    if isinstance(value, dict):
        items = [(key, words, other) for key, one in value.items() for words, other in changed(one)]
        return [(f"[{key!r}]{words}", {**value, key: other}) for key, words, other in items]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return []
    others: list[float] = [0.75 * value, 1.25 * value]
    if isinstance(value, int):
        others = [floor(others[0]), ceil(others[1])] if value > 0 else [value - 1, value + 1]
    # three quarters of nothing, or of what has no end, are the same
    return [(f" = {value:.6g} -> {other:.6g}", other) for other in others if abs(other - value) > 0.0]


def holders(module: ModuleType, name: str) -> list[ModuleType]:
    """Modules that have the constant: others than its own only import public ones."""
    others = [m for key, m in sys.modules.items() if key.startswith(("polydraulic", "tests")) and m is not module]
    value = getattr(module, name)
    return [module, *(m for m in others if name[0] != "_" and vars(m).get(name) is value)]


def put(module: ModuleType, name: str, value: object) -> None:
    """Give a constant another value, or none, where it stands for a default argument as well."""
    old = getattr(module, name)
    delattr(module, name)
    if value is not REMOVED:
        setattr(module, name, value)
    if isinstance(old, int):  # one object stands for all of its value
        return
    for one in vars(module).values():
        if isinstance(one, FunctionType) and one.__module__ == module.__name__:
            one.__defaults__ = one.__defaults__ and tuple(value if d is old else d for d in one.__defaults__)
            one.__kwdefaults__ = one.__kwdefaults__ and {
                key: value if d is old else d for key, d in one.__kwdefaults__.items()
            }


def passes(tests: list[str], limit: float, places: list[ModuleType], name: str, value: object) -> bool:
    """Whether tests pass within so many seconds of work in a fork in which a constant has another value, or is none."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    signal.setitimer(signal.ITIMER_PROF, limit)  # of the processor: others may be at work
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    for place in places:
        put(place, name, value)
    os._exit(pytest.main([*OPTIONS, *tests]))


def judge(module: str) -> tuple[Counter[str], list[str]]:
    """Numbers of changes by what came of them, and those that no test notices."""
    tests, loaded = tests_of(module), importlib.import_module(f"polydraulic.{module}")
    begun = process_time()
    with redirect_stdout(StringIO()) as said:
        passed = bool(tests) and pytest.main([*OPTIONS, *tests]) == 0  # in this process: forks need not load it again
    if not passed:
        sys.exit(f"{said.getvalue()}{' '.join(tests) or 'no test'}: fails as it is")
    limit = 10.0 + 10.0 * (process_time() - begun)
    counts, left = Counter[str](), []
    for name in constants(module):
        places, others = holders(loaded, name), changed(getattr(loaded, name))
        unnoticed = [words for words, other in others if passes(tests, limit, places, name, other)]
        if others and len(unnoticed) == len(others) and passes(tests, limit, places, name, REMOVED):
            counts["not covered"] += len(others)
            left.append(f"{name} is read by none of these tests")
        else:
            counts["killed"] += len(others) - len(unnoticed)
            counts["survived"] += len(unnoticed)
            left += [f"{name}{words}" for words in unnoticed]
    return counts, left


def told(counts: Counter[str]) -> str:
    """Numbers of changes in words."""
    return f"{counts.total()} changes of constants: " + ", ".join(
        f"{counts[outcome]} {outcome}" for outcome in OUTCOMES
    )


def main(chosen: list[str]) -> None:
    """Print what is noticed, module by module, and in all."""
    os.chdir(ROOT)
    sys.dont_write_bytecode = True
    # a kernel keeps the constants that it was compiled with, on the disk as well
    os.environ.setdefault("NUMBA_DISABLE_JIT", "1")
    total = Counter[str]()
    with tempfile.TemporaryDirectory() as examples:
        os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = examples  # of failures, which are meant here
        for module in modules(chosen):
            counts, left = judge(module)
            total += counts
            print("\n    ".join([f"{module}: {told(counts)}", *left]), flush=True)
    print(f"in all {told(total)}")


if __name__ == "__main__":
    main(sys.argv[1:])
