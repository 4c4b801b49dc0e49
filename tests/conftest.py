import gc
import os
import sys

if "PYTEST_XDIST_WORKER" in os.environ:  # before NumPy is loaded: one worker per processor, one thread per worker
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numba
import pytest
from hypothesis import settings
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher

from polydraulic import build_flow, cli, load_machine, load_scenario, simulate
from polydraulic._kernel_cache import KernelCache


def compiled_untraced(compile_it):
    """Compilation without the tracer of `make coverage`, which takes a third longer: nothing of the package runs in it."""

    def compile_signature(dispatcher, signature):
        tracer = sys.gettrace()
        sys.settrace(None)
        try:
            return compile_it(dispatcher, signature)
        finally:
            sys.settrace(tracer)

    return compile_signature


def compiled_by_one(compile_it, folder):
    """Compilation in one process at a time: what another has begun is waited for, and then read from the cache.

    A function is locked while those that it calls are compiled, and none the other way round, so that nobody waits in a circle.
    """
    import fcntl

    def compile_signature(dispatcher, signature):
        if not isinstance(dispatcher._cache, KernelCache):
            return compile_it(dispatcher, signature)
        function, inlined = dispatcher.py_func, dispatcher.targetoptions.get("no_cpython_wrapper", False)
        with (
            global_compiler_lock,
            open(folder / f"{function.__module__}.{function.__qualname__}.{inlined}", "w") as lock,
        ):
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compile_it(dispatcher, signature)

    return compile_signature


Dispatcher.compile = compiled_untraced(Dispatcher.compile)
settings.register_profile("quick", max_examples=60, deadline=None, derandomize=True)
settings.load_profile("quick")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is imported and collected stays: to look through it for garbage again and again takes a fifth of the time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """What is slow to compile is slow where it is compiled."""
    if not numba.config.DISABLE_JIT:
        for item in items:
            if item.get_closest_marker("slow_to_compile"):
                item.add_marker("slow")


@pytest.fixture(scope="session", autouse=True)
def one_compiler(tmp_path_factory):
    """Workers do not compile the same at once: where all are busy, one that waits takes no longer, and the others are quicker."""
    if "PYTEST_XDIST_WORKER" in os.environ and not numba.config.DISABLE_JIT:
        folder = tmp_path_factory.getbasetemp().parent / "compiling"
        folder.mkdir(exist_ok=True)
        Dispatcher.compile = compiled_by_one(Dispatcher.compile, folder)


@pytest.fixture(scope="session")
def machine():
    return load_machine("cat215b")


@pytest.fixture(scope="session")
def build():
    """Build a flow model by name: tables are coarse, since plain Python fills them slowly."""
    return lambda name, machine: build_flow(name, machine, **({"points": 8} if name == "lookup" else {}))


@pytest.fixture(scope="session", params=["single_08", "single_05"])
def scenario(request):
    return load_scenario(request.param)


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Call the command line in a folder of its own, by arguments or by one line: exit code, output, errors."""

    def run(*arguments):
        monkeypatch.chdir(tmp_path)
        given = arguments[0].split() if len(arguments) == 1 else map(str, arguments)
        monkeypatch.setattr(sys, "argv", ["polydraulic", *given])
        with pytest.raises(SystemExit) as stop:
            cli.main()
            sys.exit(0)
        printed = capsys.readouterr()
        return stop.value.code or 0, printed.out, printed.err

    return run


@pytest.fixture(scope="session")
def whole(machine):
    """The whole machine in motion, by two flow models."""
    scenario = load_scenario("task")
    return {name: simulate(machine, name, scenario, t_end=0.6) for name in ("exact", "iterative")}


@pytest.fixture(scope="session")
def boom_runs(machine):
    scenario = load_scenario("single_08")
    return {name: simulate(machine, name, scenario, t_end=0.2) for name in ("exact", "polynomial")}
