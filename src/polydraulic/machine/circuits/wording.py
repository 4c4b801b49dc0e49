"""How text about n valves is put together: a pattern for each of them, and lines that are not too long."""

from collections.abc import Iterable

_WIDTH = 120


def each(pattern: str, first: int, last: int) -> str:
    """`pattern` for the numbers `first` to `last` with commas between; `~` stands for the number."""
    return ", ".join(pattern.replace("~", str(i)) for i in range(first, last + 1))


def repeated(pattern: str, numbers: Iterable[int]) -> str:
    """`pattern` for each number on lines of its own; `~` stands for the number, `~-` and `~+` for its neighbours."""
    return "\n".join(pattern.replace("~-", str(i - 1)).replace("~+", str(i + 1)).replace("~", str(i)) for i in numbers)


def valves(n: int) -> str:
    """Parameters of every kernel of a circuit: conductances, port pressures and the pump."""
    return f"{each('k_~', 1, n)}, {each('p_~', 1, n)}, pump"


def definitions(parts: Iterable[str]) -> str:
    """Parts as one text, two empty lines between them, long calls broken behind a comma."""
    text = "\n\n\n".join(part.strip("\n") for part in parts) + "\n"
    return "\n".join(_folded(line) for line in text.split("\n"))


def _folded(line: str) -> str:
    if len(line) <= _WIDTH:
        return line
    indent = " " * (len(line) - len(line.lstrip()))
    cut = line.rindex(", ", 0, _WIDTH) + 1
    return f"{line[:cut]}\n{_folded(f'{indent}        {line[cut:].lstrip()}')}"
