"""What is wrong, how sure that is, and what else it could be: every direction fitted alone to the blocks since the alarm's beginning."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.watch.directions import Direction
from polydraulic.watch.sequential import Since


class Suspect(NamedTuple):
    """A fault that would explain what was seen.

    Attributes
    ----------
    name, title : str
        Title with the size found.
    probability : float
        Among the directions that are watched, one of them alone.
    size, error : float
        In the unit of the catalogue, with a standard error; nan of what has no size.
    harmless : bool
        Whether it is unusual work and no fault.
    """

    name: str
    title: str
    probability: float
    size: float
    error: float
    harmless: bool


def named_suspects(
    directions: Sequence[Direction], seen: Since, together: float, chances: np.ndarray, listed: Sequence[int]
) -> list[Suspect]:
    """Suspects that `diagnose` has listed, in its order, with sizes from what was seen.

    Parameters
    ----------
    directions : sequence of Direction
    seen : Since
        Of the blocks since the beginning.
    together : float
        What evidence is divided by.
    chances : (n_direction,) array
        Probability of each direction.
    listed : sequence of int
        Numbers of directions.
    """
    scatter = np.maximum(scatter_of(seen), together)
    found = []
    for k in listed:
        d, known = directions[k], max(float(seen.information[k]), 1e-300)
        size, error = float(seen.pull[k] / known * d.size), float(np.sqrt(scatter[k] / known) * d.size)
        likely = 0.0  # one after the other, as kernels and C do: `sum` of newer Pythons rounds otherwise
        for other, chance in zip(directions, chances.tolist(), strict=True):
            likely += chance if other.name == d.name else 0.0
        found.append(Suspect(d.name, _title(d, size, error), likely, size, error, d.harmless))
    return found


def scatter_of(seen: Since) -> np.ndarray:
    """Variance of blocks about the size that fits best, by their information, (n_direction,)."""
    return np.asarray((seen.squares - seen.pull**2 / np.maximum(seen.information, 1e-300)) / max(seen.blocks - 1, 1))


def _title(d: Direction, size: float, error: float) -> str:
    if "{}" not in d.title:
        return d.title
    return sized(d.title, size, error) if d.unit == "1" else d.title.format(f"{size:.0f} +- {error:.0f} {d.unit}")


def sized(words: str, size: float, error: float) -> str:
    """Words with a share and its standard error in place of their ``{}``, in percent."""
    digits = max(0, min(2, int(np.ceil(-np.log10(max(100.0 * error, 1e-3))))))
    return words.format(f"{100.0 * size:.{digits}f} +- {100.0 * error:.{digits}f} %")
