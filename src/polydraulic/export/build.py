"""The C compiler of this machine: a shared library from sources."""

import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from polydraulic.errors import InputError
from polydraulic.files import Scratch

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off")  # no fused multiply-adds: the bits of the package
_SYSTEM = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
_MACHINE = {"x86_64": "x86_64", "amd64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
_ZIG = (sys.executable, "-m", "ziglang", "cc")
# Names of FMI 3.0 and of clang; an old C library, so that the binaries load on old systems.
_TARGETS = {
    "x86_64-linux": "x86_64-linux-gnu.2.17",
    "aarch64-linux": "aarch64-linux-gnu.2.17",
    "x86_64-windows": "x86_64-windows-gnu",
    "x86_64-darwin": "x86_64-macos",
    "aarch64-darwin": "aarch64-macos",
}
_ENDING = {"linux": ".so", "darwin": ".dylib", "windows": ".dll"}


def find_compiler(asked: str | None = None) -> list[str] | None:
    """The command to compile with.

    Parameters
    ----------
    asked : str, optional
        A command; the first of `COMPILERS` that is installed if not given, else that of the package ziglang. None if it
        is empty.

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
        return [asked]
    found = next((name for name in COMPILERS if shutil.which(name)), None)
    return [found] if found else [*_ZIG] if find_spec("ziglang") else None


def cross_compilers() -> dict[str, list[str]]:
    """Commands that compile for other platforms, by their names in FMI 3.0.

    Raises
    ------
    InputError
        If the package ziglang is not installed.
    """
    if find_spec("ziglang") is None:
        raise InputError("binaries for other platforms need the package ziglang: pip install ziglang")
    return {name: [*_ZIG, "-target", target] for name, target in _TARGETS.items() if name != platform_tuple()}


def compile_library(
    command: Sequence[str], text: Mapping[str, str], sources: Sequence[str], flags: Sequence[str] = ()
) -> bytes:
    """Compile a shared library.

    Parameters
    ----------
    command : sequence of str
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
    return _compiled(command, text, ["-shared", "-fPIC", *flags, *sources])


def compile_program(command: Sequence[str], text: Mapping[str, str], sources: Sequence[str], path: Path) -> None:
    """Compile a program that uses the mathematical functions of the C library, and put it to `path`.

    Parameters
    ----------
    command, text, sources
        As for `compile_library`.
    path : Path

    Raises
    ------
    InputError
        If the sources do not compile.
    """
    path.write_bytes(_compiled(command, text, [*sources, "-lm"]))
    path.chmod(0o755)


def _compiled(command: Sequence[str], text: Mapping[str, str], arguments: Sequence[str]) -> bytes:
    with Scratch() as scratch:
        folder = scratch.folder
        with scratch.writing():
            for name, content in text.items():
                (folder / name).write_text(content, encoding="utf-8")
        done = subprocess.run([*command, *FLAGS, *arguments, "-o", "made"], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            sources = [argument for argument in arguments if argument.endswith(".c")]
            raise InputError(f"{' '.join(command)} cannot compile {', '.join(sources)}: {done.stderr.strip()[:2000]}")
        return (folder / "made").read_bytes()


def platform_tuple() -> str:
    """Name of the machine as FMI 3.0 writes it."""
    machine = platform.machine().lower()
    return f"{_MACHINE.get(machine, machine)}-{_SYSTEM.get(sys.platform, sys.platform)}"


def library_ending(machine: str) -> str:
    """Ending of shared libraries on a platform."""
    return _ENDING.get(machine.rpartition("-")[2], ".so")
