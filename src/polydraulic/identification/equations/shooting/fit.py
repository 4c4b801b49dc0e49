"""Numbers of a machine found through simulation: windows of a log are run, and what sensors would read is brought to what they read.

Multiple shooting: every window begins from a state of its own, which is found together with the numbers (Bock, in Modelling of Chemical Reaction
Systems, Springer 1981). States enter their window alone, so that they are eliminated window by window, and what is left is a
small system over the numbers. Numbers and states have priors; rows far off count less; what each channel's noise is follows from the residuals.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import table_of
from polydraulic.identification.equations.numbers.estimates import Estimates, correlation_of, estimates_of, left_out
from polydraulic.identification.equations.numbers.unbounded import (
    Unbounded,
    from_unbounded,
    slopes_of_values,
    to_unbounded,
    unbounded,
    with_rises_open,
)
from polydraulic.identification.equations.shooting.elimination import Linearised, Reduced, without_states
from polydraulic.identification.equations.shooting.information import state_spreads
from polydraulic.identification.equations.shooting.runs import (
    Driven,
    commanded_travel,
    driven_windows,
    first_states,
    shoot,
    window_slopes,
)
from polydraulic.identification.equations.shooting.windows import Windows, cut_windows, sensors_of
from polydraulic.networks.growth.levenberg_marquardt import Damping, Descent, Equations, lower_loss
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

SECONDS = 2.0
MOST_WINDOWS = 128
# how much larger noise is taken, so that priors hold while states are far off; steps at most
_PASSES = ((8.0, 4), (3.0, 4), (1.0, 5), (1.0, 12), (1.0, 40))
_ROBUST = 3.0  # standard deviations
_SHARES = 1.0, 0.3, 0.0  # of a window's own step of its states that are tried
_SETTLING = 3  # steps of the states before numbers move
_RULES = Damping(
    largest=1e6,
    raise_by=4.0,
    raise_more=2.0,
    lower=lambda share: 0.2 if share > 0.5 else (0.5 if share > 0.2 else 2.0),
    enough=3e-4,
    smallest=1e-9,
    least_relative=1e-3,
    least_added=1e-12,
    last_steps=1,
)


class ShootingFit(NamedTuple):
    """Numbers found through simulation.

    Attributes
    ----------
    machine : LayoutMachine
        With the numbers that were found.
    estimates : Estimates
        Standard deviations by how far numbers move when a window is left out; of 32 windows, 90 % intervals hold the truth in 87 % of cases.
    noise : dict
        Standard deviation of the residuals of each channel, SI.
    before : dict
        The same with the numbers that the search began from.
    windows : int
    seconds : float
        Length of a window.
    travel : dict
        Largest travel of each spool that commands drive, m.
    settled : bool
        Whether the search ended because no step gained much, not because it had made as many as it may.
    """

    machine: LayoutMachine
    estimates: Estimates
    noise: dict[str, float]
    before: dict[str, float]
    windows: int
    seconds: float
    travel: dict[str, float]
    settled: bool


class ShootingStage(NamedTuple):
    """How far a search has come: what it can go on from.

    Attributes
    ----------
    passes : int
        That are done.
    reached : Descent
        How far the next one has come.
    u : (n,) array
        Coordinates of the numbers.
    states : (n_window, 4 n_function) array
    noise : (n_channel,) array
        As it is taken in that pass.
    """

    passes: int
    reached: Descent
    u: np.ndarray
    states: np.ndarray
    noise: np.ndarray


def fit_by_shooting(
    log: Table | str | Sequence[Table | str],
    machine: LayoutMachine,
    spreads: Mapping[str, float],
    *,
    sensors: Sequence[str] | None = None,
    seconds: float = SECONDS,
    most: int = MOST_WINDOWS,
    begun: ShootingStage | None = None,
    keep: Callable[[ShootingStage], object] = lambda reached: None,
    progress: Progress = quiet,
) -> ShootingFit:
    """Find numbers of a machine such that its runs read what sensors read.

    Parameters
    ----------
    log : Table or its file
        ``time``, ``NAME.voltage`` and ``NAME.angle`` (``NAME.position`` of a joint that slides) of every function, and whatever else of a run's
        columns was measured, in SI.
    machine : LayoutMachine
        Its numbers are the means of the priors.
    spreads : mapping from path to standard deviation, SI
        Of the numbers that are to be found.
    sensors : sequence of str, optional
        Columns that runs are compared with; all that the log and a run have if not given.
    seconds : float
        Length of a window.
    most : int
        Windows at most, spread over the log; the time that it takes grows with them.
    begun : ShootingStage, optional
        What the same search had come to when it was interrupted.
    keep : function (ShootingStage)
        Told after every step what the search has come to.
    progress : Progress, optional

    Returns
    -------
    ShootingFit

    Raises
    ------
    InputError
        As `cut_windows` and `unbounded`; a sensor that the log or a run does not have; runs that diverge with the numbers to begin with.
    """
    numbers = unbounded(machine, spreads)
    table, source = table_of(log, None, partial=True)
    known = sensors_of(machine, table)
    unknown = [name for name in sensors or () if name not in known]
    if unknown:
        raise InputError(
            f"{source}: sensor {unknown[0]!r} is no column that both the log and a run have; there are {', '.join(known)}"
        )
    windows = cut_windows(
        machine, table, known if sensors is None else list(dict.fromkeys(sensors)), seconds=seconds, most=most
    )
    search = _Search(machine, numbers, windows)
    u, first, reached = to_unbounded(numbers, numbers.start), 0, Descent()
    if begun is not None and search.goes_on_from(begun):
        u, first, reached = begun.u, begun.passes, begun.reached
    total, done = (sum(steps for _, steps in passes) for passes in (_PASSES, _PASSES[:first]))
    last = reached
    for number, (looser, steps) in enumerate(_PASSES[first:], first):

        def told(now: Descent, u: np.ndarray, number: int = number, done: int = done, steps: int = steps) -> None:
            nonlocal last
            assert search.here is not None
            last = now
            keep(ShootingStage(number, now, u, search.here.states, search.noise))
            progress("identify", done + min(now.steps, steps), total)

        u = search.lowered(u, looser, steps, reached, told)
        done, reached = done + steps, Descent()
    progress("identify", total, total)
    columns = [channel.column for channel in windows.channels]
    found = search.machine_at(u)
    return ShootingFit(
        found,
        search.estimates(u),
        dict(zip(columns, search.noise.tolist(), strict=True)),
        dict(zip(columns, search.before.tolist(), strict=True)),
        len(windows.first),
        seconds,
        commanded_travel(found, windows),
        last.steps < _PASSES[-1][1],
    )


class _Search:
    """Lowers the misfit of all windows; keeps the states, which `lower_loss` does not see."""

    def __init__(self, machine: LayoutMachine, numbers: Unbounded, windows: Windows) -> None:
        self.machine, self.numbers, self.windows = machine, numbers, windows
        self.heard = ~np.isnan(windows.measured)  # nothing is compared elsewhere
        self.measured = np.where(self.heard, windows.measured, 0.0)
        self.first = first_states(machine, windows)
        self.state_spread = state_spreads(windows)
        start = shoot(machine, windows, self.first)
        if start is None:
            raise InputError(
                "the machine diverges from the states of the log; bring its numbers to begin with nearer to it"
            )
        self.before = self.noise = self._spread_of(start - self.measured)
        self.here: Linearised | None = None

    def machine_at(self, u: np.ndarray) -> LayoutMachine:
        values = from_unbounded(self.numbers, u)
        return self.machine.with_values(dict(zip(self.numbers.paths, values.tolist(), strict=True)))

    def _spread_of(self, off: np.ndarray) -> np.ndarray:
        """Robust standard deviation of each channel, not below the sensor's own noise."""
        least = np.array([channel.noise for channel in self.windows.channels])
        own = [np.abs(off[self.heard[..., k], k]) for k in range(len(least))]
        return np.maximum([1.4826 * float(np.median(values)) if len(values) else 0.0 for values in own], least)

    def goes_on_from(self, begun: ShootingStage) -> bool:
        """Take states and noise of a search that was interrupted; not those of other numbers, windows or sensors."""
        fits = [part.shape for part in begun[2:]] == [self.numbers.start.shape, self.first.shape, self.noise.shape]
        if fits and self._possible(begun.u) is not None:
            before, self.noise = self.noise, begun.noise
            self.here = self._at(begun.u, begun.states)
            self.noise = before if self.here is None else begun.noise
        return self.here is not None

    def lowered(
        self, u: np.ndarray, looser: float, steps: int, reached: Descent, told: Callable[[Descent, np.ndarray], None]
    ) -> np.ndarray:
        """Coordinates with less loss, where noise is `looser` times what residuals show; some of the steps may be made already."""
        if self.here is None:
            self.noise = looser * self.noise
            self.here = self._settled(u)
        elif not reached.steps:
            off = self.here.off.reshape(self.windows.measured.shape) * self.noise
            self._scale_to(looser * self._spread_of(off))
        self._u = u
        if not reached.steps:
            self._evaluate(with_rises_open(self.numbers, u), np.inf)
        found, _ = lower_loss(
            self._u,
            self._equations(self._u, self.here),
            self._evaluate,
            _RULES,
            max_steps=steps,
            max_attempts=2 * steps,
            begun=reached,
            keep=lambda now: told(now, self._u),
        )
        return found

    def _scale_to(self, noise: np.ndarray) -> None:
        assert self.here is not None
        scale = np.broadcast_to(self.noise / noise, self.heard.shape).reshape(len(self.here.off), -1)
        states, off, over_numbers, over_states = self.here
        self.here = Linearised(states, off * scale, over_numbers * scale[..., None], over_states * scale[..., None])
        self.noise = noise

    def _settled(self, u: np.ndarray) -> Linearised:
        """States that fit the numbers to begin with, so that numbers do not answer for them."""
        states, off = self.first, None
        for _ in range(_SETTLING):
            here = self._at(u, states, off, paths=())
            if here is None:
                break
            states, off = self._best_states(u, states, self._reduced(here).own)
        made = self._at(u, states, off)
        if made is None:
            raise InputError("runs diverge near the numbers to begin with; bring them nearer to the log")
        return made

    def _evaluate(self, u: np.ndarray, limit: float) -> Equations | None:
        assert self.here is not None
        reduced = self._reduced(self.here)
        step = from_unbounded(self.numbers, u) - from_unbounded(self.numbers, self._u)
        states, off = self._best_states(u, self.here.states - reduced.to_numbers @ step, reduced.own)
        if off is None or not self._loss(u, states, off) < limit:
            return None
        made = self._at(u, states, off)
        if made is None:
            return None
        self.here, self._u = made, u
        return self._equations(u, made)

    def _best_states(self, u: np.ndarray, states: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """For each window the states, along their own step, with the least loss; windows do not see each other."""
        own = own / np.maximum(1.0, np.abs(own / self.state_spread).max(axis=1, keepdims=True))
        best, best_off, least = states, None, np.full(len(states), np.inf)
        machine = self._possible(u)
        driven = None if machine is None else driven_windows(machine, self.windows)
        for share in _SHARES:
            there = states - share * own
            off = None if machine is None else self._off(machine, there, driven)
            if off is None:
                continue
            loss = self._window_loss(there, off)
            better = loss < least
            best = np.where(better[:, None], there, best)
            best_off = off if best_off is None else np.where(better[:, None], off, best_off)
            least = np.minimum(least, loss)
        return best, best_off

    def _possible(self, u: np.ndarray) -> LayoutMachine | None:
        try:
            return self.machine_at(u)
        except InputError:
            return None

    def _off(self, machine: LayoutMachine, states: np.ndarray, driven: Driven | None = None) -> np.ndarray | None:
        """Residuals over noise, (n_window, m); None where runs diverge."""
        rows = shoot(machine, self.windows, states, driven)
        off = (rows - self.measured) / self.noise if rows is not None else None
        return None if off is None else np.where(self.heard, off, 0.0).reshape(len(off), -1)

    def _at(
        self, u: np.ndarray, states: np.ndarray, off: np.ndarray | None = None, paths: Sequence[str] | None = None
    ) -> Linearised | None:
        machine = self.machine_at(u)
        off = self._off(machine, states) if off is None else off
        if off is None:
            return None
        rows = off.reshape(self.measured.shape) * self.noise + self.measured
        wanted = self.numbers.paths if paths is None else paths
        found = window_slopes(machine, self.windows, states, rows, wanted, self.numbers.spread)
        if found is None:
            return None
        parts = [np.where(self.heard[..., None], part / self.noise[:, None], 0.0) for part in found]
        return Linearised(states, off, *(part.reshape(*off.shape, part.shape[-1]) for part in parts))

    def _loss(self, u: np.ndarray, states: np.ndarray, off: np.ndarray) -> float:
        prior = (from_unbounded(self.numbers, u) - self.numbers.start) / self.numbers.spread
        return float(prior @ prior + self._window_loss(states, off).sum())

    def _window_loss(self, states: np.ndarray, off: np.ndarray) -> np.ndarray:
        begun = (states - self.first) / self.state_spread
        data = 2.0 * _ROBUST**2 * (np.sqrt(1.0 + (off / _ROBUST) ** 2) - 1.0)
        return np.asarray(data.sum(axis=1) + (begun * begun).sum(axis=1))

    def _reduced(self, here: Linearised) -> Reduced:
        weight = 1.0 / np.sqrt(1.0 + (here.off / _ROBUST) ** 2)
        return without_states(here, weight, here.states - self.first, self.state_spread)

    def _equations(self, u: np.ndarray, here: Linearised) -> Equations:
        reduced, spread = self._reduced(here), self.numbers.spread
        values, own = from_unbounded(self.numbers, u), slopes_of_values(self.numbers, u)
        gram = reduced.gram.sum(0) + np.diag(1.0 / spread**2)
        gradient = reduced.gradient.sum(0) + (values - self.numbers.start) / spread**2
        return Equations(
            own.T @ gram @ own, own.T @ gradient, self._loss(u, here.states, here.off), float(np.sum(here.off**2))
        )

    def estimates(self, u: np.ndarray) -> Estimates:
        """Values with a covariance from how gradients scatter from window to window."""
        assert self.here is not None
        reduced, spread = self._reduced(self.here), self.numbers.spread
        seen, prior, count = reduced.gram.sum(0), np.diag(1.0 / spread**2), len(reduced.gradient)
        # few windows say little of their scatter: then the noise alone says as much
        share = len(spread) / (len(spread) + count)
        inverse = np.linalg.inv(seen + prior)
        covariance = (1.0 - share) * left_out(reduced.gram, reduced.gradient, prior)
        covariance += inverse @ (share * seen + prior) @ inverse
        return estimates_of(
            self.numbers.paths, from_unbounded(self.numbers, u), covariance, spread, correlation_of(seen, spread)
        )
