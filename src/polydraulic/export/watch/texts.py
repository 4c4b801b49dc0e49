"""Lists of names and numbers in the C of a machine that is watched."""

from collections.abc import Iterable
from textwrap import fill

from polydraulic.export.c.text import string

_WIDTH = 120


def enumerators(name: str, of: Iterable[str]) -> str:
    """Members of an enum that count from 0."""
    return "\n".join(f"    {name}_{each.replace('.', '_')}".upper() + f" = {k}," for k, each in enumerate(of))


def strings(of: Iterable[str]) -> str:
    """Members of an array of texts."""
    return ",\n".join(f"        {string(each)}" for each in of)


def number_lines(of: Iterable[float]) -> str:
    """Members of an array of numbers, which read back exactly, in lines."""
    return fill(", ".join(map(repr, of)), _WIDTH, subsequent_indent="    ")
