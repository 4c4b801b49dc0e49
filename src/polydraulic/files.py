"""Files that are whole or absent: written beside their place and moved there at the end; and folders for what waits on disk.

A process that is killed leaves its temporary files. They are locked while somebody writes them, so that whoever writes into the same
folder next knows those that nobody will finish, and removes them.
"""

import errno
import fcntl
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from polydraulic.errors import InputError

_MARK = ".unfinished-"
_UNFINISHED = re.compile(rf"\..*{re.escape(_MARK)}[a-z0-9_]{{8}}(\.[^.]*)?")
_SCRATCH = "polydraulic-"
_LOCK = "in-use"
_TRIES, _TAKEN = 100, "other processes remove temporary files before they are in use"
_MOST = 40  # letters of a name that its temporary file has, too


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path` and move it there if all went well: a file is whole or absent.

    Parameters
    ----------
    path : str or Path
        A link is followed: the file that it points to is replaced.

    Raises
    ------
    InputError
        If the folder cannot be made or written, or there is something at `path` that is no file.
    """
    path = Path(path)
    _check_name(path)
    with _saying(f"cannot write {path}", "choose a folder you may write to"):
        place = Path(os.path.realpath(path))
        if place.exists() and not (place.is_file() or place.is_dir()):  # a device or a pipe would be replaced by a file
            raise InputError(f"cannot write {path}: it is no file")
        place.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = _beside(place)
    try:
        _remove_unfinished(place.parent)
        with _saying(f"cannot write {path}"):
            yield temporary
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o666 & ~mask)
            temporary.replace(place)
    finally:
        temporary.unlink(missing_ok=True)
        os.close(handle)


def _check_name(path: Path) -> None:
    """Refuse names that no file can have before any work is done for it."""
    try:
        with suppress(FileNotFoundError):
            path.lstat()
    except ValueError as error:  # a null character, a lone surrogate
        raise InputError(f"cannot write {str(path)!r}: no file can have this name; choose another") from error
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise InputError(f"cannot write {path}: {error.strerror}; choose shorter names") from error


def check_new(path: str | Path) -> None:
    """Raise InputError if a file that people change by hand is there already."""
    if Path(path).exists():
        raise InputError(f"{path} is there already; choose another name, or remove it first")


def check_writable(path: str | Path) -> None:
    """Raise InputError if no file can be written there: before work is done that would be lost."""
    _check_name(Path(path))
    with _saying(f"cannot write {path}", "choose a folder you may write to"):
        place = Path(os.path.realpath(path))
        if place.is_dir():
            raise InputError(f"cannot write {path}: it is a folder")
        place.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = _beside(place)
        temporary.unlink(missing_ok=True)
        os.close(handle)


def check_apart(out: str | Path, read: Iterable[str | Path]) -> None:
    """Check that what is to be written would not replace a file that it is made from.

    Raises
    ------
    InputError
        If it would.
    """
    for path in map(Path, read):
        if path.exists() and Path(out).exists() and path.samefile(out):
            raise InputError(f"{out}: is the file that is read, which would be replaced; write to another name")


def write_text(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all."""
    write_texts({Path(path): text})


def write_texts(texts: Mapping[Path, str]) -> None:
    """Write text files that belong together: none takes its place before all are written.

    Parameters
    ----------
    texts : mapping from path to text
    """
    with ExitStack() as together:
        for path, text in texts.items():
            together.enter_context(replacing(path)).write_text(text, encoding="utf-8")


class Scratch:
    """A folder for what does not fit into memory; removed by `close`, or by the next process that makes one if this one is killed.

    Attributes
    ----------
    folder : Path

    Raises
    ------
    InputError
        If there is no place for temporary files.
    """

    def __enter__(self) -> "Scratch":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __init__(self) -> None:
        with _saying("cannot write temporary files", "the environment variable TMPDIR names another folder"):
            for _ in range(_TRIES):
                self._made = tempfile.TemporaryDirectory(prefix=_SCRATCH, ignore_cleanup_errors=True)
                self.folder = Path(self._made.name)
                self._handle = os.open(self.folder / _LOCK, os.O_RDWR | os.O_CREAT, 0o600)
                if _lock(self._handle) and (self.folder / _LOCK).exists():
                    break
                self.close()  # somebody took it for forsaken before it was locked
            else:
                raise OSError(_TAKEN)
        for other in self.folder.parent.glob(f"{_SCRATCH}*"):
            with suppress(OSError), _forsaken(other / _LOCK):
                shutil.rmtree(other, ignore_errors=True)

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Turn errors of what is written there into an InputError that names the folder."""
        with _saying(
            f"cannot write temporary files to {self.folder.parent}",
            "the environment variable TMPDIR names another folder",
        ):
            yield

    def close(self) -> None:
        """Remove the folder; again does nothing."""
        if self._handle >= 0:
            self._made.cleanup()
            os.close(self._handle)
            self._handle = -1


@contextmanager
def _saying(what: str, remedy: str = "") -> Iterator[None]:
    try:
        yield
    except OSError as error:
        why = error.strerror or str(error)
        raise InputError(f"{what}: {why}" + (f"; {remedy}" if remedy else "")) from error


def _beside(place: Path) -> tuple[int, Path]:
    """A locked temporary file in the folder of a file; its handle keeps the lock."""
    for _ in range(_TRIES):
        handle, name = tempfile.mkstemp(
            prefix=f".{place.name[:_MOST]}{_MARK}", suffix=place.suffix[:_MOST], dir=place.parent
        )
        if _lock(handle) and os.path.exists(name):
            return handle, Path(name)
        os.close(handle)  # somebody took it for unfinished before it was locked
    raise OSError(_TAKEN)


def _lock(handle: int) -> bool:
    """Lock a file; False if another process has it. Where a file system knows no locks, nothing is ever taken for unfinished."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def _remove_unfinished(folder: Path) -> None:
    """Remove temporary files that nobody writes any more; what cannot be looked at stays."""
    with suppress(OSError):
        for entry in os.scandir(folder):
            if _UNFINISHED.fullmatch(entry.name):
                with suppress(OSError), _forsaken(Path(entry.path)):
                    os.unlink(entry.path)


@contextmanager
def _forsaken(path: Path) -> Iterator[None]:
    """Hold the lock of a file that was left by a process; an OSError where another process holds it, or there are no locks."""
    handle = os.open(path, os.O_RDWR)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(handle)
