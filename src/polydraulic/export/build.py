"""The C compiler of this machine: a shared library from sources."""

import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from polydraulic.errors import InputError

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC")  # no fused multiply-adds: the bits of the package
_SYSTEM = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
_MACHINE = {"x86_64": "x86_64", "amd64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
_ENDING = {"linux": ".so", "darwin": ".dylib", "windows": ".dll"}


def find_compiler(asked: str | None = None) -> str | None:
    """The command to compile with.

    Parameters
    ----------
    asked : str, optional
        A command; the first of `COMPILERS` that is installed if not given, and none if it is empty.

    Raises
    ------
    InputError
        If the one that was asked for is not installed.
    """
    if asked == "":
        return None
    if asked is not None:
        if shutil.which(asked) is None:
            raise InputError(f"compiler {asked!r} is not installed; leave it out to use one of {list(COMPILERS)}")
        return asked
    return next((name for name in COMPILERS if shutil.which(name)), None)


def compile_library(command: str, text: Mapping[str, str], sources: Sequence[str], flags: Sequence[str] = ()) -> bytes:
    """Compile a shared library.

    Parameters
    ----------
    command : str
        The compiler.
    text : mapping from file name to text
        Sources and headers.
    sources : sequence of str
        Files that are to be compiled.
    flags : sequence of str
        Besides `FLAGS`.

    Returns
    -------
    bytes
        The library.

    Raises
    ------
    InputError
        If the sources do not compile.
    """
    with TemporaryDirectory() as folder:
        for name, content in text.items():
            (Path(folder) / name).write_text(content, encoding="utf-8")
        done = subprocess.run(
            [command, *FLAGS, *flags, *sources, "-o", "library"], cwd=folder, capture_output=True, text=True
        )
        if done.returncode:
            raise InputError(f"{command} cannot compile {', '.join(sources)}: {done.stderr.strip()[:2000]}")
        return (Path(folder) / "library").read_bytes()


def platform_tuple() -> str:
    """Name of the machine as FMI 3.0 writes it."""
    machine = platform.machine().lower()
    return f"{_MACHINE.get(machine, machine)}-{_SYSTEM.get(sys.platform, sys.platform)}"


def library_ending() -> str:
    """Ending of shared libraries."""
    return _ENDING.get(_SYSTEM.get(sys.platform, ""), ".so")
