"""Lags, and how complex a dynamic model may be: a walk over choices, each judged by how it runs on rows held out."""

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

from polydraulic.errors import InputError

LADDER = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)  # lags that are tried, denser where they are short
_PATIENCE = 2  # steps of the walk without a gain
_GAIN = 0.01  # another choice has to lower the error by this share


class Choice(NamedTuple):
    """A model that was tried.

    Attributes
    ----------
    input_lags, output_lags : tuple of int
    increments : bool
        Whether the networks learnt the change of the output rather than the output.
    layers : tuple of int
        Layers of each output's network at most, 0 for a linear one; of a given estimator -1, since its own settings hold.
    horizon : int or None
        Rows over which coefficients were refined.
    error : float
        Free-run error on held-out blocks as a part of the standard deviation, rms over blocks and outputs; infinite if nothing
        was left open, since then it is not computed.
    """

    input_lags: tuple[int, ...]
    output_lags: tuple[int, ...]
    increments: bool
    layers: tuple[int, ...]
    horizon: int | None
    error: float = inf

    @property
    def longest(self) -> int:
        """Rows needed before the first answer."""
        return max([1, *self.input_lags, *self.output_lags])


class Options(NamedTuple):
    """What may be chosen; lags of None are found on the ladder. The first of each is where the walk begins."""

    input_lags: tuple[int, ...] | None
    output_lags: tuple[int, ...] | None
    ladder: tuple[int, ...]
    increments: tuple[bool, ...]
    layers: tuple[int, ...]
    horizons: tuple[int | None, ...]
    n_output: int

    @property
    def open(self) -> bool:
        """Whether there is more than one choice."""
        lags = self.input_lags is None or self.output_lags is None
        return lags or any(len(some) > 1 for some in (self.increments, self.layers, self.horizons))

    @property
    def longest(self) -> int:
        """Longest lag of any choice."""
        lags = [self.ladder if some is None else some for some in (self.input_lags, self.output_lags)]
        return max(1, *lags[0], *lags[1])

    def at(self, n_in: int, n_out: int) -> Choice:
        """Return the first choice with so many lags from the ladder."""
        lags = [
            self.ladder[:n] if own is None else own
            for n, own in zip((n_in, n_out), (self.input_lags, self.output_lags), strict=True)
        ]
        return Choice(lags[0], lags[1], self.increments[0], self.layers[:1] * self.n_output, self.horizons[0])


def select(options: Options, judge: Callable[[Choice], float], say: Callable[[Choice], None]) -> list[Choice]:
    """Walk to better lags, a rung of either ladder or of both at a time; then try what else is open.

    Parameters
    ----------
    options : Options
    judge : function of Choice
        Error of a choice.
    say : function of Choice
        Told of each one.

    Returns
    -------
    list of Choice
        All that were tried in order, and the chosen one once more at the end.
    """
    tried: dict[Choice, Choice] = {}

    def judged(choice: Choice) -> Choice:
        key = choice._replace(error=0.0)
        if key not in tried:
            tried[key] = choice._replace(error=judge(choice))
            say(tried[key])
        return tried[key]

    best, here, waited = judged(options.at(1, 1)), (1, 1), 0
    rungs = [(a, b) for a, b in ((0, 1), (1, 0), (1, 1))]
    rungs = [
        (a, b)
        for a, b in rungs
        if not ((a and options.input_lags is not None) or (b and options.output_lags is not None))
    ]
    while waited < _PATIENCE:
        steps = [(here[0] + a, here[1] + b) for a, b in rungs if max(here[0] + a, here[1] + b) <= len(options.ladder)]
        if not steps:
            break
        found = [(judged(options.at(*step)), step) for step in steps]
        nearest, here = min(found, key=lambda one: one[0].error)
        waited = 0 if _better(nearest, best) else waited + 1
        best = nearest if waited == 0 else best
    best = _simplest([judged(best._replace(increments=option)) for option in options.increments])
    for k in range(options.n_output):
        layers = [(*best.layers[:k], depth, *best.layers[k + 1 :]) for depth in sorted(options.layers)]
        others = [best._replace(layers=own, horizon=rows) for own in layers for rows in options.horizons]
        best = _simplest([judged(other) for other in others])
    return [*tried.values(), best]


def checked_lags(name: str, lags: str | Sequence[int], least: int) -> tuple[int, ...] | None:
    """Lags in rising order; None where they are to be chosen."""
    if isinstance(lags, str):
        if lags != "auto":
            raise InputError(f"{name} = {lags!r}: must be 'auto' or a sequence of whole numbers")
        return None
    good = all(isinstance(lag, int) and not isinstance(lag, bool) and lag >= least for lag in lags)
    if not good or len(set(lags)) < len(lags):
        raise InputError(f"{name} = {list(lags)!r}: must be different whole numbers, at least {least}")
    return tuple(sorted(lags))


def _simplest(choices: Sequence[Choice]) -> Choice:
    """Return the first that no other betters; simple ones stand first."""
    least = min(choice.error for choice in choices)
    return next(choice for choice in choices if choice.error <= least / (1.0 - _GAIN))


def _better(one: Choice, other: Choice) -> bool:
    return one.error < (1.0 - _GAIN) * other.error
