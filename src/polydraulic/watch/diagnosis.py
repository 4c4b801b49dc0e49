"""What is wrong, how sure that is, and what else it could be: every direction fitted alone to the blocks since the alarm's beginning."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.watch.directions import Direction
from polydraulic.watch.kernels.evidence import diagnose
from polydraulic.watch.kernels.numbers import MOST_LISTED
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


def suspects_of(directions: Sequence[Direction], seen: Since, together: float) -> list[Suspect]:
    """Suspects, the most likely first; of others only those that could be.

    Parameters
    ----------
    directions : sequence of Direction
    seen : Since
        Of the blocks since the beginning.
    together : float
        What evidence is divided by.
    """
    n, names = len(directions), [d.name for d in directions]
    chances, listed = np.zeros(n), np.zeros(MOST_LISTED, dtype=np.int64)
    down = np.array([d.both for d in directions], dtype=np.int64)
    group = np.array([names.index(name) for name in names], dtype=np.int64)
    sums = np.concatenate(seen[:3])
    count = diagnose(sums, 0, n, float(together), down, group, chances, 0, listed, 0)
    return named_suspects(directions, seen, together, chances, listed[:count].tolist())


def named_suspects(
    directions: Sequence[Direction], seen: Since, together: float, chances: np.ndarray, listed: Sequence[int]
) -> list[Suspect]:
    """Suspects by the numbers of their directions, with sizes from what was seen.

    Parameters
    ----------
    directions, seen, together
        As of `suspects_of`.
    chances : (n_direction,) array
        Probability of each direction.
    listed : sequence of int
    """
    found, scatter = [], np.maximum(scatter_of(seen), together)
    for k in listed:
        d, known = directions[k], max(float(seen.information[k]), 1e-300)
        size, error = float(seen.pull[k] / known * d.size), float(np.sqrt(scatter[k] / known) * d.size)
        likely = sum(float(chance) for other, chance in zip(directions, chances, strict=True) if other.name == d.name)
        found.append(Suspect(d.name, _title(d, size, error), likely, size, error, d.harmless))
    return found


def evidence_of(directions: Sequence[Direction], seen: Since, together: float) -> np.ndarray:
    """Logarithm of the likelihood ratio of each direction in the size that fits best, (n_direction,); minus infinity where that would go the wrong way."""
    allowed = np.array([d.both for d in directions]) | (seen.pull > 0.0)
    evidence = 0.5 * seen.pull**2 / np.maximum(seen.information, 1e-300) / together
    return np.where(allowed & (seen.information > 0.0), evidence, -np.inf)


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
