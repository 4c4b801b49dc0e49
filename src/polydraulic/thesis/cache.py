"""Results kept on disk under a hash of the code and parameters that made them: a killed study resumes where it was."""

import hashlib
import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from polydraulic.files import write_text
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.model_file import load_models, save_models
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table, read_table, write_table

_DATA = ".data.json"
_SOURCES = (".py", ".toml", ".json", ".css")
_SHOWN = ("cli/", "terminal.py", "plotting/", "pages/", "thesis/report/")  # compute nothing


@dataclass(frozen=True)
class Cache:
    """Named results in one folder, each made once: in memory, then as a file.

    Attributes
    ----------
    folder : Path or None
        None keeps them in memory only.
    """

    folder: Path | None
    memory: dict[str, Any] = field(default_factory=dict)

    def models(self, name: str, make: Callable[[], Sequence[Model]]) -> list[Model]:
        """Networks, as a model file."""
        return list(self._keep(name, ".json", make, load_models, save_models))

    def table(self, name: str, make: Callable[[], Table]) -> Table:
        """A table with its units and info, as Parquet."""
        found: Table = self._keep(name, ".parquet", make, read_table, write_table)
        return found

    def data(self, name: str, make: Callable[[], Any]) -> Any:
        """Numbers, strings, lists and dicts, as JSON."""

        def write(value: Any, path: Path) -> None:
            write_text(path, json.dumps(value, allow_nan=False) + "\n")

        return self._keep(name, _DATA, make, lambda path: json.loads(path.read_text(encoding="utf-8")), write)

    def has_data(self, name: str) -> bool:
        """Whether `data` of this name need not be made."""
        return name in self.memory or (self.folder is not None and _sound(self._path(name, _DATA)))

    def _keep(
        self,
        name: str,
        ending: str,
        make: Callable[[], Any],
        read: Callable[[Path], Any],
        write: Callable[[Any, Path], None],
    ) -> Any:
        if name not in self.memory:
            path = None if self.folder is None else self._path(name, ending)
            if path is not None and _sound(path):
                self.memory[name] = read(path)
            else:
                value = make()
                if path is not None:
                    write(value, path)
                    write_text(_witness(path), _content(path))
                self.memory[name] = value
        return self.memory[name]

    def _path(self, name: str, ending: str) -> Path:
        assert self.folder is not None
        return self.folder / (name.replace(" ", "-") + ending)


def _witness(path: Path) -> Path:
    return path.with_name(path.name + ".sha256")


def _content(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _sound(path: Path) -> bool:
    """Whether a file is as it was written: one that is damaged is made again."""
    try:
        return _witness(path).read_text(encoding="utf-8") == _content(path)
    except (OSError, UnicodeDecodeError):
        return False


@dataclass(frozen=True)
class Lab:
    """What every study works with: a machine, and what has been computed of it so far.

    Attributes
    ----------
    machine : LayoutMachine
    computed : Cache
        Networks, runs, maps and numbers; made anew when code below `thesis.report` or a parameter changes.
    shown : Cache
        Chapters and figures; made anew when any code or parameter changes.
    say : function of str
        Told what is being computed.
    """

    machine: LayoutMachine
    computed: Cache
    shown: Cache
    say: Callable[[str], object] = lambda what: None


def open_lab(
    machine: LayoutMachine, folder: Path | None = None, say: Callable[[str], object] = lambda what: None
) -> Lab:
    """Return the lab of a machine, with what earlier runs of the same code left in `folder`.

    Results of other code or parameters are removed: they would never be read again.

    Parameters
    ----------
    machine : LayoutMachine
    folder : Path, optional
        Without one, results stay in memory.
    say : function of str
        Told what is being computed.
    """

    def cache(kind: str, *, all_code: bool) -> Cache:
        if folder is None:
            return Cache(None)
        place = folder / f"{kind}-{_digest(machine, all_code=all_code)}"
        for other in folder.glob(f"{kind}-*"):
            if other != place:
                shutil.rmtree(other, ignore_errors=True)
        return Cache(place)

    return Lab(machine, cache("computed", all_code=False), cache("shown", all_code=True), say)


def _digest(machine: LayoutMachine, *, all_code: bool) -> str:
    """Hash of a machine, the package's sources and the libraries that decide results; 12 hex digits."""
    import numpy
    import sklearn

    found = hashlib.sha256(repr((machine, numpy.__version__, sklearn.__version__)).encode())
    for name, source in _sources(files("polydraulic"), ""):
        if all_code or not name.startswith(_SHOWN):
            found.update(name.encode() + b"\0" + source.read_bytes())
    return found.hexdigest()[:12]


def _sources(folder: Traversable, where: str) -> list[tuple[str, Traversable]]:
    found = []
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            found += _sources(entry, f"{where}{entry.name}/")
        elif entry.name.endswith(_SOURCES):
            found.append((where + entry.name, entry))
    return found
