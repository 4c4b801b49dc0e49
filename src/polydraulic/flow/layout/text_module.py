"""A text of kernels as a module: one real file, named by the digest of its content, which is run only if it still has that digest.

A file is what numba's cache, `inspect` and the translator to C want. Where nothing can be written the text lives in memory, and what
is compiled of it is not kept. Two processes may write the same file at once: each moves a whole one into its place.

numba knows the type of a named tuple again by the names of class and fields, not by the class: of two texts that both have a
``Plant``, the second would have every number of it looked at in Python at each call. So its classes have names of their own.
"""

import hashlib
import linecache
import logging
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import ModuleType

from polydraulic._kernel import cache_folder
from polydraulic.errors import InputError
from polydraulic.files import write_text

_log = logging.getLogger("polydraulic")


@cache
def loaded(text: str) -> ModuleType:
    """Run a text as a module.

    Parameters
    ----------
    text : str
        Python source that this package has written.
    """
    name = f"polydraulic_layout_{hashlib.sha256(text.encode()).hexdigest()[:24]}"
    path = _file(text, name)
    module = ModuleType(name)
    module.__file__ = str(path)
    # tracebacks and `inspect` find the text, with or without a file
    linecache.cache[str(path)] = (len(text), None, text.splitlines(keepends=True), str(path))
    sys.modules[name] = module  # where numba looks for the types of what it has kept
    exec(compile(text, str(path), "exec"), module.__dict__)
    for cls in vars(module).values():
        if isinstance(cls, type) and issubclass(cls, tuple) and cls.__module__ == name:
            cls.__name__ = f"{cls.__name__}_{name[-8:]}"
    return module


def written_name(cls: type) -> str:
    """Name under which a text defines a class."""
    return cls.__qualname__.rpartition(".")[2]


def kept_text(key: str, write: Callable[[], str]) -> str:
    """A text that was written in another process for the same key, or that is written now; a damaged file counts for nothing.

    Parameters
    ----------
    key : str
        All that the text depends on beside the sources of this package, by which the folder is named.
    write : function
        Writes it: that takes longer than to compile many a function.
    """
    folder = cache_folder()
    if folder is None:
        return write()
    path = Path(folder) / f"text_{hashlib.sha256(key.encode()).hexdigest()[:24]}.txt"
    with suppress(OSError, UnicodeDecodeError):
        digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        if hashlib.sha256((key + text).encode()).hexdigest() == digest:
            return text
    text = write()
    try:
        write_text(path, f"{hashlib.sha256((key + text).encode()).hexdigest()}\n{text}")
    except (OSError, InputError) as error:
        _log.warning("%s cannot be written (%s): the text of a layout is written anew in each run", path, error)
    return text


def _file(text: str, name: str) -> Path:
    """A file that holds exactly this text, or a name for it in memory."""
    folder = cache_folder()
    if folder is not None:
        path = Path(folder) / f"{name}.py"
        try:
            if not path.is_file() or path.read_bytes() != text.encode():
                write_text(path, text)
            return path
        except (OSError, InputError) as error:
            _log.warning("%s cannot be written (%s): the layout is compiled anew in each run", path, error)
    return Path(f"<{name}>")
