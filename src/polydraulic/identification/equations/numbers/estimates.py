"""What an identification says of each number: its value, how well it is known, and against what it trades."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

COVERED = 1.6448536269514722  # standard deviations on both sides that hold 90 % of a normal distribution
KNOWN = 0.5  # of the prior's standard deviation: a log that leaves more has not determined a number
HIDDEN = 0.9  # of it: a number of which a log says next to nothing
_TRADES = 0.9  # correlation
_SHOWN = 3


class Estimate(NamedTuple):
    """One number of a machine.

    Attributes
    ----------
    path : str
    value : float, SI
    sd : float, SI
        Standard deviation.
    spread : float, SI
        Standard deviation of the prior.
    determined : bool
        Whether the log says more than the prior did.
    """

    path: str
    value: float
    sd: float
    spread: float
    determined: bool

    @property
    def low(self) -> float:
        """Lower end of the interval that holds the truth with 90 %."""
        return self.value - COVERED * self.sd

    @property
    def high(self) -> float:
        """Upper end of it."""
        return self.value + COVERED * self.sd

    @property
    def hidden(self) -> bool:
        """Whether the log says next to nothing of it."""
        return self.sd > HIDDEN * self.spread


class Estimates(NamedTuple):
    """Numbers of a machine as a log tells them.

    Attributes
    ----------
    numbers : tuple of Estimate
    covariance : (n, n) array, SI
    trades : tuple of str
        In words, which numbers that are not determined trade against which others.
    """

    numbers: tuple[Estimate, ...]
    covariance: np.ndarray
    trades: tuple[str, ...]

    def of(self, path: str) -> Estimate:
        """The number at that path."""
        return next(number for number in self.numbers if number.path == path)


def estimates_of(
    paths: Sequence[str], values: np.ndarray, covariance: np.ndarray, spreads: np.ndarray, correlation: np.ndarray
) -> Estimates:
    """Estimates from a fit.

    Parameters
    ----------
    paths : sequence of str
    values : (n,) array, SI
    covariance : (n, n) array
        Of values.
    spreads : (n,) array
        Standard deviations of the priors.
    correlation : (n, n) array
        Of values where the log alone is asked: from the inverse of its information.
    """
    sd = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    numbers = tuple(
        Estimate(path, float(value), float(own), float(spread), bool(own < KNOWN * spread))
        for path, value, own, spread in zip(paths, values, sd, spreads, strict=True)
    )
    return Estimates(numbers, covariance, tuple(_trades(numbers, correlation)))


def _trades(numbers: Sequence[Estimate], correlation: np.ndarray) -> list[str]:
    found = []
    for k, number in enumerate(numbers):
        if number.determined:
            continue
        others = [j for j in np.argsort(-np.abs(correlation[k])).tolist() if j != k]
        others = [j for j in others if abs(correlation[k, j]) > _TRADES][:_SHOWN]
        words = [f"{numbers[j].path} ({'rises' if correlation[k, j] > 0.0 else 'falls'} with it)" for j in others]
        said = f"trades against {', '.join(words)}" if words else "hardly shows in this log"
        found.append(f"{number.path} {said}")
    return found


def unhidden(parts: int, numbers: float) -> float:
    """Factor of squares of pulls on a solution, summed over parts of a log that do not depend on each other.

    The solution gives way to each part's own pull: of as many numbers as the log determines, that hides a share of `numbers` in `parts`
    (MacKinnon and White, J. Econometrics 29 (1985) 305, HC1).
    """
    return parts / max(parts - numbers, 0.1 * parts)


def left_out(gram: np.ndarray, gradient: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """Covariance of a solution by how far it moves when one part of a log is left out, (n, n).

    Few parts that show a number, such as those in which a boom lifts, pull a solution towards themselves, each by as much as it shows: what
    is left of their own pull would be too small (the jackknife; HC3 of MacKinnon and White, J. Econometrics 29 (1985) 305).

    Parameters
    ----------
    gram : (n_part, n, n) array
        Information of each part.
    gradient : (n_part, n) array
        Pull of each part at the solution.
    prior : (n, n) array
        Information of the priors.
    """
    others = gram.sum(0) + prior - gram
    moved = np.linalg.solve(others, gradient[..., None])[..., 0]
    moved = moved - moved.mean(0)
    return np.asarray(moved.T @ moved * (len(gram) - 1) / len(gram))


def correlation_of(information: np.ndarray, spreads: np.ndarray) -> np.ndarray:
    """How numbers go together where a log alone is asked; directions that it does not see count as seen a thousandth of the prior."""
    scaled = information * np.outer(spreads, spreads)
    inverse = np.linalg.inv(scaled + 1e-3 * np.eye(len(spreads)))
    sd = np.sqrt(np.diagonal(inverse))
    return np.asarray(inverse / np.outer(sd, sd))
