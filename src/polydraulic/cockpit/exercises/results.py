"""Results of exercises: a line each in one file, and attempts compared by exercise, mode and guard."""

import json
import math
import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

NAME = "results.jsonl"
_MOST = 64 * 1024 * 1024  # bytes of the file that are read, its last ones


def add_result(folder: Path, result: Mapping[str, Any]) -> None:
    """Append one result; it is on the disk when this returns.

    Raises
    ------
    OSError
    """
    folder.mkdir(parents=True, exist_ok=True)
    handle = os.open(folder / NAME, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        size = os.fstat(handle).st_size
        # by a crash: what follows stands on a line of its own
        torn = size > 0 and os.pread(handle, 1, size - 1) != b"\n"
        line = json.dumps(result, allow_nan=False) + "\n"
        content = memoryview(("\n" + line if torn else line).encode())
        while content:
            content = content[os.write(handle, content) :]
        os.fsync(handle)
    finally:
        os.close(handle)


def read_results(folder: Path) -> list[dict[str, Any]]:
    """All results, oldest first; lines that a crash has torn are left out.

    Raises
    ------
    OSError
    """
    try:
        with (folder / NAME).open("rb") as file:
            file.seek(max(os.fstat(file.fileno()).st_size - _MOST, 0))
            lines = file.read().decode("utf-8", "replace").split("\n")
    except FileNotFoundError:
        return []
    found = []
    for line in lines:
        try:
            item = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(item, dict) and isinstance(item.get("values"), dict):
            found.append(item)
    return found


def compared_attempts(results: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Medians of finished attempts, by machine, exercise, mode, and whether tips were guarded against in coordinated mode.

    Returns
    -------
    list of dict
        ``machine``, ``exercise``, ``mode``, ``guard``, ``attempts`` and the median of each value.
    """
    groups: dict[tuple[str, str, str, bool], list[Mapping[str, Any]]] = defaultdict(list)
    for result in results:
        if result.get("finished"):
            machine, exercise, mode = (str(result.get(key)) for key in ("machine", "exercise", "mode"))
            guarded = mode == "coordinated" and bool(result.get("guard"))
            groups[machine, exercise, mode, guarded].append(result["values"])
    found = []
    for (machine, exercise, mode, guarded), values in sorted(groups.items()):
        names = dict.fromkeys(name for value in values for name in value)
        numbers = {name: [v[name][0] for v in values if name in v and _is_number(v[name])] for name in names}
        found.append(
            {
                "machine": machine,
                "exercise": exercise,
                "mode": mode,
                "guard": guarded,
                "attempts": len(values),
                "values": {name: median(all_of) for name, all_of in numbers.items() if all_of},
            }
        )
    return found


def _is_number(pair: Any) -> bool:
    return isinstance(pair, list) and len(pair) == 2 and isinstance(pair[0], int | float) and math.isfinite(pair[0])
