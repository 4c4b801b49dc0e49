"""Compiled functions kept on disk: a file each, whole or absent, and never a reason to fail.

numba's own cache takes its folder for sound: a full disk or a damaged file ends the program, and of two processes that compile one
function for different types at once, one may later load the code of the other. Here a file holds one signature, begins with a
digest, and says what it is of; whatever is wrong with it, the function is compiled again and the file replaced.

Of kernels that compiled code alone calls bitcode is kept, which their callers take in. numba makes machine code of whatever it
compiles, and loads it, which nobody would run where a function is inlined wherever it is called; function passes are left to the
callers, whose machine code is another one for that, with the same bits.
"""

import hashlib
import os
import pickle
import re
import secrets
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding
from numba.core import caching
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult, compile_result
from numba.core.serialize import dumps

_DIGEST = hashlib.sha256().digest_size
_BITCODE = "bitcode"
_warned = False


def warn_uncached(folder: object, reason: object) -> None:
    """Say once, in one line, that functions are compiled in every run."""
    global _warned
    if not _warned:
        _warned = True
        message = (
            f"compiled functions cannot be kept in {folder} ({reason}), so that every run compiles them anew; "
            "the environment variable NUMBA_CACHE_DIR names another folder"
        )
        warnings.warn_explicit(message, RuntimeWarning, __name__, 1)  # a place without a source, which would be shown


def keep_compiled(dispatcher: Any, function: Callable[..., Any]) -> None:
    """Let a compiled function keep its machine code in `numba.config.CACHE_DIR`."""
    dispatcher._cache = KernelCache(function, dispatcher.targetoptions)


class _NoMachineCode:
    """In place of the code generator, which would write the address of a function's environment into its machine code."""

    def set_env(self, env_name: str, env: Any) -> None:
        pass


class _InlinedLibrary(JITCodeLibrary):
    """A kernel with all that it calls, optimised, and no way to run it."""

    @classmethod
    def kept(cls, codegen: Any, name: str, bitcode: bytes) -> "_InlinedLibrary":
        """The library that `serialize_using_object_code` has kept."""
        library = cls(codegen, name)
        library._final_module = binding.parse_bitcode(bitcode)
        library._finalize_final_module()
        return library

    def _optimize_functions(self, ll_module: Any) -> None:
        """Nothing: a kernel is optimised with what it calls, and once more with each caller."""
        ll_module.data_layout = self._codegen._data_layout

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """No function has an address."""
        return 0

    @property
    def codegen(self) -> _NoMachineCode:
        return _NoMachineCode()

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """What is kept, by the name under which numba asks for it."""
        return self.name, _BITCODE, self._get_module_for_linking().as_bitcode()


class InlinedCompiler(Compiler):
    """numba's compiler for functions of which no machine code is made: an argument `pipeline_class`."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a function into a library of its own."""
        self.state.library = _InlinedLibrary(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)


def _rebuilt(target_context: Any, kept: tuple[Any, ...]) -> CompileResult:
    """A compiled function from what numba reduces one to, its library being bitcode."""
    (name, _, bitcode), fndesc, env, signature, objectmode, lifted, annotation, reload_init, environments = kept
    library = _InlinedLibrary.kept(target_context.codegen(), name, bitcode)
    return compile_result(
        target_context=target_context,
        typing_context=target_context.typing_context,
        library=library,
        environment=env,
        entry_point=target_context.get_executable(library, fndesc, env),
        fndesc=fndesc,
        type_annotation=annotation,
        signature=signature,
        objectmode=objectmode,
        lifted=lifted,
        reload_init=reload_init,
        referenced_envs=environments,
    )


class _Locator(caching.UserProvidedCacheLocator):
    """The folder that is set, and no other: its files may be read even where none can be added."""

    def ensure_cache_path(self) -> None:
        pass


class _Implementation(caching.CompileResultCacheImpl):
    _locator_classes = (_Locator,)

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        library = payload[0]
        return (_rebuilt if library[1] == _BITCODE else super().rebuild)(target_context, payload)


class _Files:
    """The files of one function.

    Parameters
    ----------
    begin : str
        Path of all of them, up to the part that tells signatures apart.
    state : tuple
        What must be the same for a file to be read: version of numba, digest of the source, options.
    """

    def __init__(self, begin: str, state: tuple[object, ...]) -> None:
        self._begin, self._state = begin, state

    def _path(self, key: object) -> Path:
        named = re.sub(r" at 0x[0-9a-f]+", "", repr((key, self._state)))
        return Path(f"{self._begin}.{hashlib.sha256(named.encode()).hexdigest()[:16]}.nbc")

    def load(self, key: object) -> Any:
        """What was saved under a key; None where there is nothing, or it is damaged."""
        try:
            content = self._path(key).read_bytes()
        except OSError:
            return None
        digest, body = content[:_DIGEST], content[_DIGEST:]
        if hashlib.sha256(body).digest() != digest:
            return None
        state, found, data = pickle.loads(body)
        return data if (state, found) == (self._state, key) else None

    def save(self, key: object, data: object) -> None:
        """Write a file, or raise an OSError and leave the old one."""
        body, path = dumps((self._state, key, data)), self._path(key)
        temporary = path.with_suffix(f".{secrets.token_hex(4)}.tmp")
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_bytes(hashlib.sha256(body).digest() + body)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)

    def flush(self) -> None:
        """Nothing: files of another state are never read."""


class KernelCache(caching.FunctionCache):
    """numba's cache of one function, compiled with certain options, with files that are checked."""

    _impl_class = _Implementation

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function)
        locator = self._impl.locator
        begin = os.path.join(self._cache_path, self._impl.filename_base)
        compiled_with = (*sorted(options.items()), int(numba.config.OPT))
        self._cache_file = _Files(begin, (numba.__version__, locator.get_source_stamp(), compiled_with))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load a compiled function, or None: whatever cannot be used is compiled again.

        numba would first import all that it compiles with, SciPy's linear algebra among it, which takes longer than all that is
        loaded. Machine code that allocates nothing needs none of it, and a compilation does it by itself.
        """
        try:
            with self._guard_against_spurious_io_errors():
                return self._load_overload(sig, target_context)
        except Exception:
            return None
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a compiled function, or warn."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            self.disable()
            warn_uncached(self._cache_path, error.strerror)
