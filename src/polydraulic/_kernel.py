"""`@kernel` and `@driver`: compiled functions whose cache notices every edit.

numba's disk cache looks at the file that holds a function, not at the files of the functions it calls: an edit to
`valve.py` would leave a stale time loop behind. Here the cache folder is named by a digest of every source that can
stand in a kernel, so that an edit of any of them starts afresh. Kernels above `simulation` call these alone, and each stands in a file that numba watches.

A kernel is a pure function of floats and named tuples, inlined where it is called; a driver owns arrays and loops.
Neither may allocate (`_nrt=False` makes an allocation a compile error). With ``NUMBA_DISABLE_JIT=1`` both are
plain Python. docs/architecture.md lists the rules for kernel code.
"""

import hashlib
import os
import shutil
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import numba

from polydraulic._kernel_cache import InlinedCompiler, keep_compiled, warn_uncached

F = TypeVar("F", bound=Callable[..., Any])

_DRIVER_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "boundscheck": False,
    "_nrt": False,
    "no_cfunc_wrapper": True,
}
_KERNEL_OPTIONS: dict[str, Any] = {**_DRIVER_OPTIONS, "forceinline": True}
# for what compiled code alone calls: to take named tuples out of Python, and bring them back, is longer than most kernels
INLINED_OPTIONS: dict[str, Any] = {**_KERNEL_OPTIONS, "no_cpython_wrapper": True}
_KEEP_DAYS = 30


# What kernels are made of: the layers up to `simulation` (parameters are types to them, constants may come from units), and `identification`,
# whose fits have kernels of their own.
_COMPILED = (
    "control",
    "watch",
    "_kernel",
    "_kernel_cache",
    "elementary",
    "units",
    "parameters",
    "networks",
    "machine",
    "flow",
    "simulation",
    "identification",
)


def source_digest() -> str:
    """Digest of every Python source, and page of one, that can stand in a kernel: names the cache folder."""
    root = os.path.dirname(__file__)
    tops = [os.path.join(root, name) for name in _COMPILED]
    found = [f"{top}.py" for top in tops if os.path.isfile(f"{top}.py")]
    found += [os.path.join(folder, name) for top in tops for folder, _, names in os.walk(top) for name in names]
    digest = hashlib.sha256()
    for path in sorted(path for path in found if path.endswith((".py", ".py.txt"))):
        digest.update(path[len(root) :].encode())
        with open(path, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()[:16]


def _cache_folder() -> str | None:
    """The folder for this state of the sources, or None where there can be none."""
    try:
        chosen = numba.config.CACHE_DIR or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        folder = Path(chosen) / "polydraulic" / source_digest()
    except RuntimeError as error:
        warn_uncached("a folder of this user", error)  # who has no home
        return None
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        warn_uncached(folder, error.strerror)
        return None
    _forget_others(folder)
    return str(folder)


def _forget_others(folder: Path) -> None:
    """Remove what other states of the sources left and nobody has used for long; other processes may do the same."""
    with suppress(OSError):
        folder.touch()
        for other in folder.parent.iterdir():
            with suppress(OSError):
                if time.time() - other.stat().st_mtime > _KEEP_DAYS * 86400:
                    shutil.rmtree(other, ignore_errors=True)


_FOLDER = None if numba.config.DISABLE_JIT else _cache_folder()


def cache_folder() -> str | None:
    """The folder in which compiled kernels, and texts that become kernels, are kept; None where nothing can be written."""
    return _FOLDER


def _compiled(function: F, options: dict[str, Any], **compiler: type) -> F:
    compiled: F = numba.njit(**options, **compiler)(function)
    if _FOLDER is not None:
        # numba reads the folder when a cache is made; other packages must not see ours
        theirs = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = _FOLDER
        try:
            keep_compiled(compiled, function)
        finally:
            numba.config.CACHE_DIR = theirs
    return compiled


def kernel(function: F) -> F:
    """Compile a pure function of floats and named tuples; it is inlined into its callers.

    Python calls one version of it, compiled functions another, to which Python has no way in: half of the time in which a layout
    is compiled would go into ways that nobody takes.
    """
    called: Any = _compiled(function, _KERNEL_OPTIONS)
    if not numba.config.DISABLE_JIT:
        # made when a caller is compiled: a run that finds its callers on disk needs none
        inlined: Callable[[], Any] = cache(
            partial(_compiled, function, INLINED_OPTIONS, pipeline_class=InlinedCompiler)
        )
        called.get_call_template = lambda *types: inlined().get_call_template(*types)
        called.get_overload = lambda signature: inlined().get_overload(signature)
    compiled: F = called
    return compiled


def driver(function: F) -> F:
    """Compile a function that loops over arrays it is given; other threads run meanwhile."""
    return _compiled(function, {**_DRIVER_OPTIONS, "nogil": True})


def in_plain_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel, and all that it calls, without the compiler: the same bits, for what is asked once and takes longer to compile."""
    plain: dict[int, Callable[..., Any]] = {}

    def without(value: Any) -> Any:
        own = getattr(value, "py_func", None)
        if own is None:
            return value
        if id(own) not in plain:
            names: dict[str, Any] = dict(own.__globals__)
            plain[id(own)] = FunctionType(own.__code__, names, own.__name__, own.__defaults__, own.__closure__)
            names.update({name: without(names[name]) for name in own.__code__.co_names if name in names})
        return plain[id(own)]

    found: Callable[..., Any] = without(function)
    return found
