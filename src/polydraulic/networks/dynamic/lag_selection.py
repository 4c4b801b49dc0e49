"""Lags, and how complex a dynamic model may be: a walk over choices, each judged by how it runs on rows held out."""

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

from polydraulic.errors import InputError

LADDER = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)  # lags that are tried, denser where they are short
_PATIENCE = 2  # steps of the walk without a gain
_GAIN = 0.01  # another choice has to lower the error by this share
_REACHES = (3, 8, 24)  # longest lags that are offered to polynomials, as far as allowed
_TERMS_GAIN = 0.03  # what many terms have to gain over few


class Choice(NamedTuple):
    """A model that was tried.

    Attributes
    ----------
    input_lags, output_lags : tuple of int
    increments : bool
        Whether the networks learnt the change of the output rather than the output.
    horizon : int or None
        Rows over which runs were to fit, None for one step ahead.
    terms : int or None
        Of the polynomials of all outputs together, constants included; None for a given estimator.
    error : float
        Free-run error on held-out blocks as a part of the standard deviation, rms over rows and outputs, mean over blocks; infinite
        if nothing was left open, since then it is not computed.
    """

    input_lags: tuple[int, ...]
    output_lags: tuple[int, ...]
    increments: bool
    horizon: int | None
    terms: int | None = None
    error: float = inf

    @property
    def longest(self) -> int:
        """Rows needed before the first answer."""
        return max([1, *self.input_lags, *self.output_lags])


class Options(NamedTuple):
    """What may be chosen; lags of None are found on the ladder. The first of each is where the search begins."""

    input_lags: tuple[int, ...] | None
    output_lags: tuple[int, ...] | None
    ladder: tuple[int, ...]
    increments: tuple[bool, ...]
    horizons: tuple[int | None, ...]

    @property
    def open(self) -> bool:
        """Whether there is more than one choice."""
        lags = self.input_lags is None or self.output_lags is None
        return lags or any(len(some) > 1 for some in (self.increments, self.horizons))

    @property
    def longest(self) -> int:
        """Longest lag of any choice."""
        lags = [self.ladder if some is None else some for some in (self.input_lags, self.output_lags)]
        return max(1, *lags[0], *lags[1])

    @property
    def most(self) -> int:
        """Choices that may be tried at most: three at each rung of both ladders, then what else is open."""
        return 1 + 6 * len(self.ladder) + len(self.increments) + len(self.horizons)

    def at(self, n_in: int, n_out: int) -> Choice:
        """Return the first choice with this many lags from the ladder."""
        lags = [
            self.ladder[:n] if own is None else own
            for n, own in zip((n_in, n_out), (self.input_lags, self.output_lags), strict=True)
        ]
        return Choice(lags[0], lags[1], self.increments[0], self.horizons[0])


def select(options: Options, judge: Callable[[Choice], float], say: Callable[[Choice], None]) -> list[Choice]:
    """Walk to better lags of a given estimator, a rung of either ladder or of both at a time; then try what else is open.

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
    free = options.input_lags is None, options.output_lags is None
    rungs = [(a, b) for a, b in ((0, 1), (1, 0), (1, 1)) if a <= free[0] and b <= free[1]]
    while waited < _PATIENCE:
        steps = [(here[0] + a, here[1] + b) for a, b in rungs if max(here[0] + a, here[1] + b) <= len(options.ladder)]
        if not steps:
            break
        found = [(judged(options.at(*step)), step) for step in steps]
        nearest, here = min(found, key=lambda one: one[0].error)
        waited = 0 if nearest.error < (1.0 - _GAIN) * best.error else waited + 1
        best = nearest if waited == 0 else best
    best = _simplest([judged(best._replace(increments=option)) for option in options.increments])
    return [*tried.values(), _simplest([judged(best._replace(horizon=rows)) for rows in options.horizons])]


def select_terms(
    options: Options, judge: Callable[[Choice], list[Choice]], say: Callable[[Choice], None]
) -> list[Choice]:
    """Choose lags, horizon and number of terms of polynomials.

    Terms are chosen one by one, so that lags on offer need not be found one by one: near ones are offered with each horizon,
    then, with the best horizon, those up to further reaches.

    Parameters
    ----------
    options : Options
    judge : function of Choice
        Choices of the same lags and horizon with one term more at a time, and their errors.
    say : function of Choice
        Told of the best of these.

    Returns
    -------
    list of Choice
        As `select`.
    """
    tried: list[Choice] = []

    def judged(choice: Choice) -> Choice:
        found = judge(choice)
        tried.extend(found)
        best = min(found, key=lambda one: one.error)
        say(best)
        return best

    reaches = sorted({sum(lag <= reach for lag in options.ladder) for reach in _REACHES} - {0} | {len(options.ladder)})
    if options.input_lags is not None and options.output_lags is not None:
        reaches = reaches[:1]
    near, *further = [options.at(n, n) for n in reaches]
    best, waited = judged(near), 0
    for rows in options.horizons[1:]:
        longer = judged(near._replace(horizon=rows))
        best, waited = (longer, 0) if longer.error < best.error else (best, waited + 1)
        if waited == _PATIENCE:
            break
    for choice in further:
        judged(choice._replace(horizon=best.horizon))
    enough = (1.0 + _TERMS_GAIN) * min(choice.error for choice in tried)
    good = [choice for choice in tried if choice.error <= enough]
    return [*tried, min(good, key=lambda choice: (choice.terms, choice.error))]


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
