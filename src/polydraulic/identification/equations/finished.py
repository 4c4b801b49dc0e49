"""Circuits that are finished, and how far simulation has come, on disk, so that an identification that was interrupted goes on where it was."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.files import write_text
from polydraulic.identification.equations.circuits import CircuitFound, ValveFound
from polydraulic.identification.equations.shooting.fit import ShootingStage
from polydraulic.networks.growth.levenberg_marquardt import Descent
from polydraulic.parameters.layout.parts import ValveCurves

_RUNS = "simulation-so-far"  # no circuit can be called so


class Finished:
    """Circuits, and how far simulation has come, that are kept in a folder, under a digest of what they came from.

    Parameters
    ----------
    folder : str, Path or None
        None keeps nothing.
    digest : str
        Of log, machine and what is free: others' circuits are not taken.
    """

    def __init__(self, folder: str | Path | None, digest: str) -> None:
        self.folder = None if folder is None else Path(folder)
        self.digest = digest

    def circuit(self, name: str) -> CircuitFound | None:
        """A finished circuit, None if there is none of that name."""
        if self.folder is None:
            return None
        try:
            data = json.loads((self.folder / f"{name}.json").read_text(encoding="utf-8"))
            return _circuit(data) if data["digest"] == self.digest else None
        except (OSError, ValueError, KeyError, TypeError):  # absent, or of another version: it is fitted again
            return None

    def keep(self, name: str, found: CircuitFound) -> None:
        """Keep a finished circuit."""
        if self.folder is not None:
            write_text(self.folder / f"{name}.json", json.dumps({"digest": self.digest, **_plain(found)}))

    def runs(self) -> ShootingStage | None:
        """How far simulation had come, None if it was not begun."""
        if self.folder is None:
            return None
        try:
            data = json.loads((self.folder / f"{_RUNS}.json").read_text(encoding="utf-8"))
            if data["digest"] != self.digest:
                return None
            parts = (np.array(data[key], dtype=np.float64) for key in ("u", "states", "noise"))
            reached = data["reached"]
            return ShootingStage(
                int(data["passes"]),
                Descent(float(reached["damping"]), *(int(reached[key]) for key in ("attempts", "steps", "slow"))),
                *parts,
            )
        except (OSError, ValueError, KeyError, TypeError):  # absent, or of another version: it begins anew
            return None

    def keep_runs(self, reached: ShootingStage) -> None:
        """Keep how far simulation has come."""
        if self.folder is not None:
            write_text(self.folder / f"{_RUNS}.json", json.dumps({"digest": self.digest, **_plain(reached)}))

    def forget(self) -> None:
        """Remove what was kept, once all is finished."""
        if self.folder is not None and self.folder.is_dir():
            for path in self.folder.glob("*.json"):
                if _is_part(path):
                    path.unlink(missing_ok=True)
            if not any(self.folder.iterdir()):
                self.folder.rmdir()


def _is_part(path: Path) -> bool:
    """Whether a file is one that was kept here: a folder may hold files of others."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(data, dict) and "digest" in data


def _plain(item: Any) -> Any:
    if isinstance(item, np.ndarray):
        return item.tolist()
    if hasattr(item, "_asdict"):
        return {key: _plain(value) for key, value in item._asdict().items()}
    if isinstance(item, dict):
        return {key: _plain(value) for key, value in item.items()}
    return [_plain(value) for value in item] if isinstance(item, list | tuple) else item


def _circuit(data: dict[str, Any]) -> CircuitFound:
    valves = {name: _valve(v) for name, v in data["valves"].items()}
    pump = {key: (float(value), float(error)) for key, (value, error) in data["pump"].items()}
    path = [(int(count), float(error)) for count, error in data["path"]]
    return CircuitFound(valves, pump, path, int(data["rows"]), [str(line) for line in data["trades"]])


def _valve(data: dict[str, Any]) -> ValveFound:
    curves = ValveCurves(**{key: tuple(map(float, values)) for key, values in data["curves"].items()})
    errors = {key: np.array(values, dtype=np.float64) for key, values in data["errors"].items()}
    pairs = {key: (data[key][0], data[key][1]) for key in ("seen", "pressure", "outlets")}
    return ValveFound(**{**data, "curves": curves, "errors": errors, **pairs})
