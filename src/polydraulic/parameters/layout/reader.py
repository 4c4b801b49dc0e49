"""The tables of a machine file, read part by part; what is wrong is collected, so that one look shows all of it."""

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from polydraulic.errors import InputError
from polydraulic.parameters.entries import read_quantity, read_switch
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.quantity import Quantity, leaf_of

Tree = TypeVar("Tree", bound=tuple)
Value = TypeVar("Value")


class Reader:
    """Reads parts of a file, and keeps what was wrong with them.

    Parameters
    ----------
    path : Path
        Of the file, for messages.

    Attributes
    ----------
    wrong : list of str
        What has been found so far, without the file's name.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.wrong: list[str] = []

    def tried(self, read: Callable[[], Value], instead: Value) -> Value:
        """Return what `read` gives; where it raises, note why and return `instead`."""
        try:
            return read()
        except InputError as error:
            self.wrong.append(str(error).removeprefix(f"{self.path}: "))
            return instead

    def require(self, good: bool, message: str) -> bool:
        """Note a message unless `good`, which is returned."""
        if not good:
            self.wrong.append(message)
        return good

    def table(self, data: Any, allowed: Collection[str], needed: Collection[str], where: str) -> Mapping[str, Any]:
        """Return a table whose keys are checked; the keys that it may hold, if any of them cannot be used."""
        self.tried(lambda: check_keys(data, allowed, needed, where), None)
        return {key: data[key] for key in data if key in allowed} if isinstance(data, Mapping) else {}

    def word(self, data: Mapping[str, Any], key: str, choices: Collection[str], where: str) -> str:
        """Return a word that stands in a table, one of `choices`; the first of these if it is none.

        Where there is nothing to choose from, a table is missing or wrong, which has been noted.
        """
        found = data.get(key)
        if key in data and (choices or not self.wrong):
            self.require(found in choices, f"{where}.{key} = {found!r}: must be one of {list(choices)}")
        return str(found) if found in choices else next(iter(choices), "")

    def number(self, data: Mapping[str, Any], key: str, quantity: Quantity, where: str) -> float:
        """Return a number in SI; nan where it is missing or wrong, which has been noted."""
        nan = float("nan")
        if key not in data:
            return nan
        return self.tried(lambda: read_quantity(data[key], quantity, f"{where}.{key}", self.path), nan)

    def numbers(self, data: Mapping[str, Any], key: str, quantity: Quantity, where: str) -> tuple[float, ...]:
        """Return a list of numbers in SI, empty where it is missing or wrong."""
        if key not in data:
            return ()
        return self.tried(lambda: read_quantity(data[key], quantity, f"{where}.{key}", self.path, -1), ())

    def components(
        self, data: Mapping[str, Any], key: str, allowed: Collection[str], quantity: Quantity, where: str
    ) -> dict[str, float]:
        """Return what a table declares of a point or of an inertia, in the order of `allowed`."""
        here = f"{where}.{key}"
        found = self.table(data.get(key, {}), allowed, (), here)
        return {name: self.number(found, name, quantity, here) for name in allowed if name in found}

    def part(
        self, cls: type[Tree], data: Mapping[str, Any], key: str, where: str, also: Collection[str] = ()
    ) -> Tree | None:
        """Return a named tuple of quantities and switches, None where one of them is wrong.

        What has a default may be left out; `also` are keys that are read elsewhere.
        """
        here = f"{where}.{key}".lstrip(".")
        if key not in data:
            return None
        hints = get_type_hints(cls, include_extras=True)
        before = len(self.wrong)
        found = self.table(
            data[key],
            (*hints, *also),
            [name for name in hints if name not in getattr(cls, "_field_defaults", {})],
            here,
        )
        values: dict[str, Any] = {}
        for name, hint in hints.items():
            leaf = leaf_of(hint)
            if name in found and leaf is not None:
                if leaf.quantity is None:
                    values[name] = self.tried(lambda n=name: read_switch(found[n], f"{here}.{n}", self.path), False)  # type: ignore[misc]
                else:
                    values[name] = self.number(found, name, leaf.quantity, here)
        return cls(**values) if len(self.wrong) == before else None
