"""Files that are whole or absent: written beside their place and moved there at the end."""

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from polydraulic.errors import InputError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path` and move it there if all went well: a file is whole or absent.

    Raises
    ------
    InputError
        If the folder cannot be made or written.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileNotFoundError):
            path.lstat()  # finds a name that is too long before the work is done
        handle, name = tempfile.mkstemp(prefix=f".{path.stem[:40]}.", suffix=path.suffix[:20], dir=path.parent)
    except ValueError as error:  # a null character, a lone surrogate
        raise InputError(f"cannot write {str(path)!r}: no file can have this name; choose another") from error
    except OSError as error:
        mend = "shorter names" if error.errno == errno.ENAMETOOLONG else "a folder you may write to"
        raise InputError(f"cannot write {path}: {error.strerror}; choose {mend}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
