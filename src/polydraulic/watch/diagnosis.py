"""What is wrong, how sure that is, and what else it could be: every direction fitted alone to the blocks since the alarm's beginning."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.watch.directions import Direction
from polydraulic.watch.sequential import Since

ELSE = 0.02  # probability from which on another fault is named
_MOST_ELSE = 4


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
    pull, information = seen.pull, seen.information
    known = np.maximum(information, 1e-300)
    amount = pull / known
    # less what a size that is free costs
    evidence = evidence_of(directions, seen, together) - 0.5 * np.log1p(information / together)
    best = float(evidence.max())
    if not best > 0.0:
        return []
    probability = np.exp(evidence - best)
    probability /= probability.sum()
    scatter = np.maximum(scatter_of(seen), together)
    found: dict[str, Suspect] = {}
    for k in np.argsort(-probability).tolist():
        d = directions[k]
        if d.name in found:  # of another size
            found[d.name] = found[d.name]._replace(probability=found[d.name].probability + float(probability[k]))
        elif not found or (probability[k] >= ELSE and len(found) <= _MOST_ELSE):
            size, error = float(amount[k] * d.size), float(np.sqrt(scatter[k] / known[k]) * d.size)
            found[d.name] = Suspect(d.name, _title(d, size, error), float(probability[k]), size, error, d.harmless)
    return sorted(found.values(), key=lambda suspect: -suspect.probability)


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
