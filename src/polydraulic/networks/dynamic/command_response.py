"""How the rate of a joint follows its command: play, dead time, lag, dead zone, and where the valve is open.

A command passes the play of whatever moves the valve, a dead time and a lag of first order; what comes out moves two ramps, one to each
side of the dead zone. Play remembers longer than a lag does, so the command is looked back at in ever longer steps; before the oldest of these
rows it counts as having come from rest. Where play explains hardly more there is none. The rate is taken
for proportional to each ramp while these numbers are sought, so that an edge is where the straight line through the motion begins; what the line
leaves is learnt afterwards. Rates are compared as travel over windows of time: noise of the joint, which a derivative would blow up, hardly counts.
Windows are half as long as the longest lag, so that speeds which differ from one piece of work to the next hardly count either, and as long as that
where a response takes longer than half of it.
A joint that is driven against a stop says nothing of its command: once stops are found, windows that touch them are left out.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.dynamic.spans import Span, rows_of

_STARTS = (0.2, 0.5, 0.75)  # edges of the dead zone, as shares of the way from rest to the end
_SIDE = 0.02  # of its range, by which a command leaves its rest for the side to be there
_RIDGE = 1e-3
_EXPLAINED = 0.2  # of the travel, below which the command does not move the joint
_CUT = 0.1  # of a response, that may come later than the longest lag
_KEPT = 0.005  # of the whole: weights below are left out
_NEAR = 0.03  # of the range: so near the end of the travel is a stop
_SHORT = 0.03  # of the range, by which a joint driven against a stop falls short
_SHOWN = 0.9  # of the way from where motion begins to the end of the lever: a full opening beyond it is hardly seen
_SHORTEST = 0.5  # dead time in rows; a shorter one cannot be told from none
_LEAST_ROWS, _MOST_ROWS = 4, 120  # of the longest lag
_USUAL = 0.8  # s
_FEWEST = 50  # windows away from stops, with fewer of which those at stops stay in
_SCALE = 0.01  # of the range: errors of the travel beyond it count less
_EVALUATIONS = 40
_REMEMBERS, _LONGER = (
    2.5,
    1.25,
)  # how far back play goes, in longest lags; and how much further back each row is, behind those that weigh
# play as a share of all that the command does: most, and where the search begins; and how much less the errors must be for it to be there
_MOST_PLAY, _FIRST_PLAY, _WORTH = 0.3, 0.05, 0.1


class Response(NamedTuple):
    """How a joint's rate follows its command.

    Attributes
    ----------
    dead_time, lag : float
        In rows; the lag is the time constant of a first order.
    weights : (n_lag,) array
        Of the command 1, 2, ... rows ago; their sum is 1.
    play : float
        How far the command turns back before the valve follows; 0 for none.
    rest : float
        Of the command, from where it is taken to have come.
    edges : tuple of (float, float)
        One for each side on which the command moves the joint: where motion begins, and where it is at its fastest.
    seen : tuple of float
        How far the command went, for each side.
    stops : (bool, bool)
        Whether the joint was driven against its lower end, and its upper one.
    continuous : bool
        Whether it turns without end, and so has no stops.
    """

    dead_time: float
    lag: float
    weights: np.ndarray
    play: float
    rest: float
    edges: tuple[tuple[float, float], ...]
    seen: tuple[float, ...]
    stops: tuple[bool, bool]
    continuous: bool = False

    @property
    def reads(self) -> tuple[int, ...]:
        """How many rows ago the command is read, the newest first: where it weighs, and with play further back in longer and longer steps."""
        weighs = (1 + np.flatnonzero(self.weights)).tolist()
        return _looked_back(weighs, len(self.weights)) if self.play else tuple(weighs)

    def ramps(self, command: np.ndarray, spans: Sequence[Span] | None = None) -> np.ndarray:
        """Openings by row, (n_row, n_side) in [0, 1]; a command counts as having been held before the first row of each span."""
        spans = [(0, len(command))] if spans is None else spans
        return _ramps(_filtered(command, spans, self.weights, self.play, self.rest), self.edges)


def away_from_stops(joint: np.ndarray, spans: Sequence[Span], stops: tuple[bool, bool]) -> np.ndarray:
    """Rows in which a joint is away from the stops that it was driven against; (n_row,) of bool."""
    known = joint[rows_of(spans)]
    low, high = float(known.min()), float(known.max())
    place = (joint - low) / max(high - low, 1e-300)
    at_stop = (stops[0] & (place < _NEAR)) | (stops[1] & (place > 1.0 - _NEAR))
    return np.logical_not(at_stop)


def longest_lag_in_rows(longest: float | None, raster: float) -> int:
    """Rows of the longest lag, from times in s; as many as usual of None.

    Raises
    ------
    InputError
        More rows than a search can take.
    """
    if longest is None:
        return max(_LEAST_ROWS, min(_MOST_ROWS, round(_USUAL / raster)))
    rows = max(_LEAST_ROWS, round(longest / raster))
    if rows > _MOST_ROWS:
        raise InputError(
            f"longest = {longest:g} s takes {rows} rows of {raster:g} s, {_MOST_ROWS} are the most: bring the log onto a raster of "
            f"{np.ceil(1e4 * longest / _MOST_ROWS) / 10.0:g} ms or more (`polydraulic import`), or give --longest {_MOST_ROWS * raster:.6g} or less"
        )
    return rows


def most_looked_back(longest_lag: int) -> int:
    """Rows that a joint with play looks back."""
    return round(_REMEMBERS * longest_lag)


def find_response(
    command: np.ndarray, joint: np.ndarray, spans: Sequence[Span], longest_lag: int, names: tuple[str, str],
    raster: float | None = None, *, continuous: bool = False, with_play: bool = True,
) -> Response:  # fmt: skip
    """Play, dead time, lag and dead zone with which the travel over windows of rows fits best.

    Parameters
    ----------
    command, joint : (n_row,) array
    spans : sequence of (start, stop)
        Rows that follow each other.
    longest_lag : int
        Rows after which the response to a command must be over, nearly.
    names : (str, str)
        Of command and joint, for messages.
    raster : float, optional
        Time between rows in s; messages tell rows without it.
    continuous : bool
        Whether the joint turns without end: it has no stops.
    with_play : bool
        Whether play is looked for, too: models with play look back `most_looked_back` rows.

    Raises
    ------
    InputError
        A command that stands still, one that does not move the joint, or a response longer than `longest_lag`.
    """
    windows = _Windows(command, joint, spans, longest_lag, max(2, longest_lag // 2))
    sides = _sides(command[windows.known], names[0])
    n = len(sides)

    def best_of(windows: _Windows) -> np.ndarray:
        first = [min(1.5, 0.3 * longest_lag), np.log(1.5), _FIRST_PLAY]
        starts = [np.array([*first, *([share, np.log(0.95 - share)] * n)]) for share in _STARTS]
        plain = min((_search(windows, sides, longest_lag, start, False) for start in starts), key=lambda one: one.cost)
        if not with_play:
            return plain.x
        starts.append(np.concatenate([plain.x[:2], [_FIRST_PLAY], plain.x[3:]]))
        loose = min((_search(windows, sides, longest_lag, start, True) for start in starts), key=lambda one: one.cost)
        return loose.x if loose.cost < (1.0 - _WORTH) * plain.cost else plain.x

    best = best_of(windows)
    longer = _Windows(command, joint, spans, longest_lag, longest_lag)
    if _left_after(longest_lag // 2, best) > _CUT:
        windows = longer
        best = best_of(windows)
    stops = (False, False) if continuous else longer.stops(*_response(best, sides, longest_lag))
    if any(stops):
        windows = windows.away_from(stops)
        best = best_of(windows)
    weights, play, rest, edges = _response(best, sides, longest_lag)
    longer = longer.away_from(stops)
    errors = longer.errors(weights, play, rest, edges)
    explained = 1.0 - float(errors @ errors) / max(float(longer.travel @ longer.travel), 1e-300)
    if not explained >= _EXPLAINED:
        raise InputError(
            f"the command {names[0]!r} explains {max(explained, 0.0):.0%} of how {names[1]!r} moves; {_EXPLAINED:.0%} is the least: each joint "
            "needs the command that moves it, in the same order, and a log in which it moves"
        )
    dead_time, lag = float(best[0]), float(np.exp(best[1]))
    if _left_after(longest_lag, best) > _CUT:
        raise InputError(f"{names[1]!r} follows {names[0]!r} with {_not_over(dead_time, lag, longest_lag, raster)}")
    return Response(dead_time, lag, weights, play, rest, edges, tuple(end for _, end in sides), stops, continuous)


def _search(
    windows: "_Windows", sides: Sequence[tuple[float, float]], longest_lag: int, start: np.ndarray, with_play: bool
) -> Any:
    """Unknowns of `_response` with which the travel in the windows fits best, from a start; without play this one is 0."""
    from scipy.optimize import least_squares

    n = len(sides)
    low = np.array([0.0, np.log(0.05), 0.0, *([0.0, np.log(0.02)] * n)])
    high = np.array([0.6 * longest_lag, np.log(0.6 * longest_lag), _MOST_PLAY, *([0.95, np.log(1.5)] * n)])
    size = np.array([0.5, 0.5, 0.05, *([0.1, 0.3] * n)])
    open_to = np.arange(len(start)) != 2 if not with_play else np.ones(len(start), dtype=bool)

    def whole(unknowns: np.ndarray) -> np.ndarray:
        return np.insert(unknowns, 2, 0.0) if not with_play else unknowns

    found = least_squares(
        lambda unknowns: windows.errors(*_response(whole(unknowns), sides, longest_lag)),
        np.clip(start, low, high)[open_to], bounds=(low[open_to], high[open_to]), diff_step=1e-3, x_scale=size[open_to],
        loss="soft_l1", f_scale=_SCALE, max_nfev=_EVALUATIONS,
    )  # fmt: skip
    found.x = whole(found.x)
    return found


def _left_after(rows: int, unknowns: np.ndarray) -> float:
    """Share of a response that comes later than these rows, at unknowns of `_response`."""
    return float(np.exp(-(rows - unknowns[0]) / np.exp(unknowns[1])))


def _not_over(dead_time: float, lag: float, longest_lag: int, raster: float | None) -> str:
    """What is wrong with a response that is longer than the longest lag, and what would do; times in rows."""
    needed = dead_time - np.log(_CUT) * lag
    if raster is None:
        step, unit, remedy = 1.0, "rows", f"longest_lag = {np.ceil(needed):.0f}"
    else:
        # two digits, rounded up
        digit = 10.0 ** (np.floor(np.log10(needed * raster)) - 1.0)
        step, unit, remedy = raster, "s", f"--longest {digit * np.ceil(needed * raster / digit):.2g}"
    return (
        f"a dead time of {dead_time * step:.2g} {unit} and a lag of {lag * step:.2g} {unit}, which is not over after the longest lag of "
        f"{longest_lag * step:.3g} {unit}: give {remedy} or more"
    )


def response_facts(response: Response, command: str, unit: str, raster: float) -> dict[str, Any]:
    """How a joint follows its command, as it stands in a model file; times in s, edges in the unit of the command.

    What a log cannot show is left out: a dead time of less than half a row is 0, and where the command never went as far as full opening,
    this is None.
    """
    ends = zip(response.edges, response.seen, strict=True)
    return {
        "command": command,
        "unit": unit,
        "dead_time": response.dead_time * raster if response.dead_time >= _SHORTEST else 0.0,
        "lag": response.lag * raster,
        "play": response.play,
        "edges": [
            [first, full if abs(full - first) <= _SHOWN * abs(end - first) else None] for (first, full), end in ends
        ],
        "seen": list(response.seen),
        "stops": list(response.stops),
        "continuous": response.continuous,
    }


def response_in_words(facts: Mapping[str, Any]) -> str:
    """The same in words."""
    unit = f" {facts['unit']}" if facts["unit"] not in ("", "1") else ""
    sides = " and ".join(
        f"beyond {first:.4g}, fully {f'beyond the {end:.4g}{unit} seen' if full is None else f'at {full:.4g}{unit}'}"
        for (first, full), end in zip(facts["edges"], facts["seen"], strict=True)
    )
    stops = [end for end, met in zip(("lower", "upper"), facts["stops"], strict=True) if met]
    met = f"driven against its {' and its '.join(stops)} stop" if stops else "never driven against a stop"
    if facts.get("continuous"):
        met = "taken to turn without end, so that no rate depends on its angle"
    lag = f"a lag of {facts['lag']:.2g} s"
    times = (
        f"after a dead time of {facts['dead_time']:.2g} s with {lag}"
        if facts["dead_time"]
        else f"with no dead time and {lag}"
    )
    play = f"with a play of {facts['play']:.2g}{unit}, " if facts.get("play") else ""
    return f"{facts['command']} moves it {sides}, {play}{times}; it was {met}"


class _Windows:
    """Windows of so many rows, half overlapping, behind the longest lag, and how far the joint moves in each as a share of its range."""

    def __init__(
        self, command: np.ndarray, joint: np.ndarray, spans: Sequence[Span], longest_lag: int, length: int
    ) -> None:
        n = longest_lag
        ends = [(s, s + length) for a, b in spans for s in range(a + n, b - n, max(1, length // 2))]
        self.known = np.zeros(len(command), dtype=bool)
        for a, b in spans:
            self.known[a:b] = True
        if not ends:
            raise InputError(
                f"no {2 * n + 1} rows follow each other: shorten the longest lag of {n} rows, or fill the gaps"
            )
        self.start, self.stop = np.array(ends).T
        self.command, self.spans = command, spans
        self.low, self.high = float(joint[self.known].min()), float(joint[self.known].max())
        self.joint, self.range = joint, max(self.high - self.low, 1e-300)
        self.travel = (joint[self.stop] - joint[self.start]) / self.range

    def errors(self, weights: np.ndarray, play: float, rest: float, edges: Sequence[tuple[float, float]]) -> np.ndarray:
        """Travel expected with the best gains of the ramps, less that of the joint; (n_window,)."""
        total = np.cumsum(self._rates(weights, play, rest, edges), axis=0)
        return np.asarray(total[self.stop] - total[self.start] - self.travel)

    def _rates(self, weights: np.ndarray, play: float, rest: float, edges: Sequence[tuple[float, float]]) -> np.ndarray:
        """By row, of ramps with gains that fit the windows best."""
        ramps = _ramps(_filtered(self.command, self.spans, weights, play, rest), edges)
        total = np.cumsum(ramps, axis=0)
        design = total[self.stop] - total[self.start]  # rows after the start
        gram = design.T @ design
        coef = np.linalg.solve(gram + _RIDGE * np.diag(np.diagonal(gram) + 1e-9), design.T @ self.travel)
        return np.asarray(ramps @ coef)

    def away_from(self, stops: tuple[bool, bool]) -> "_Windows":
        """Windows in which the joint keeps off its stops; all of them if hardly any do."""
        count = np.concatenate([[0], np.cumsum(~away_from_stops(self.joint, self.spans, stops))])
        off = count[self.stop + 1] == count[self.start]
        if off.sum() < _FEWEST:
            return self
        found = copy(self)
        found.start, found.stop, found.travel = self.start[off], self.stop[off], self.travel[off]
        return found

    def stops(self, *response: Any) -> tuple[bool, bool]:
        """Whether the joint stood at its lower end, and at its upper one, although its command drove it on."""
        rates = self._rates(*response)
        place = (self.joint - self.low) / self.range
        return _driven_on(1.0 - place, -rates, self.spans), _driven_on(place, rates, self.spans)


def _driven_on(place: np.ndarray, rates: np.ndarray, spans: Sequence[Span]) -> bool:
    """Whether a joint near its end at 1 fell short of what its command asked for, in a stretch of rows that all drive it on.

    However short that is: an operator lets go of the lever soon after the joint stands.
    """
    for a, b in spans:
        driven = (place[a : b - 1] > 1.0 - _NEAR) & (rates[a + 1 : b] > 0.0)
        change = np.diff(np.concatenate([[False], driven, [False]]).astype(np.int8))
        for first, last in zip(a + np.flatnonzero(change > 0), a + np.flatnonzero(change < 0), strict=True):
            if rates[first + 1 : last + 1].sum() - (place[last] - place[first]) > _SHORT:
                return True
    return False


def _sides(command: np.ndarray, name: str) -> list[tuple[float, float]]:
    """Rest and far end of each side on which the command has been."""
    rest, low, high = float(np.median(command)), float(command.min()), float(command.max())
    least = _SIDE * (high - low)
    found = [(rest, end) for end in (high, low) if abs(end - rest) > least]
    if not found:
        raise InputError(f"the command {name!r} stands still at {rest:g}: it moves nothing in this log")
    return found


def _response(
    unknowns: np.ndarray, sides: Sequence[tuple[float, float]], longest_lag: int
) -> tuple[np.ndarray, float, float, tuple[tuple[float, float], ...]]:
    """Weights, play, rest and edges from the unknowns.

    These are dead time, logarithm of the lag, play as a share of all that the command does, and for each side its edge and the logarithm
    of its width, as shares.
    """
    dead_time, lag = float(unknowns[0]), float(np.exp(unknowns[1]))
    rows = np.arange(longest_lag + 1)
    weights = np.diff(np.where(rows > dead_time, 1.0 - np.exp(-np.maximum(rows - dead_time, 0.0) / lag), 0.0))
    edges = []
    for (rest, end), edge, width in zip(sides, unknowns[3::2].tolist(), np.exp(unknowns[4::2]).tolist(), strict=True):
        first = rest + edge * (end - rest)
        edges.append((first, first + width * (end - rest)))
    weights = np.where(weights >= _KEPT * weights.sum(), weights, 0.0)
    play = float(unknowns[2]) * sum(abs(end - rest) for rest, end in sides)
    return weights / weights.sum(), play, sides[0][0], tuple(edges)


def _looked_back(weighs: Sequence[int], longest_lag: int) -> tuple[int, ...]:
    """Rows ago that show where play is: all of `weighs` and between, then each a quarter further back, as far as play remembers."""
    ago = list(range(weighs[0], weighs[-1] + 1))
    oldest = most_looked_back(longest_lag)
    while ago[-1] < oldest:
        ago.append(min(int(_LONGER * ago[-1]) + 1, oldest))
    return tuple(ago)


def _filtered(command: np.ndarray, spans: Sequence[Span], weights: np.ndarray, play: float, rest: float) -> np.ndarray:
    """What play and weights make of the command: at each row of the rows before it, those before its span made up; 0 outside of spans."""
    weighs, half = (1 + np.flatnonzero(weights)).tolist(), 0.5 * play
    ago = _looked_back(weighs, len(weights)) if play else tuple(weighs)
    found = np.zeros(len(command))
    for first, end in spans:
        before = np.concatenate([np.full(ago[-1], command[first]), command[first:end]])
        follows = np.full(end - first, rest)
        for back in reversed(ago):
            at = before[ago[-1] - back : len(before) - back]
            follows = np.clip(follows, at - half, at + half)
            if back <= len(weights) and weights[back - 1]:
                found[first:end] += weights[back - 1] * follows
    return found


def _ramps(command: np.ndarray, edges: Sequence[tuple[float, float]]) -> np.ndarray:
    return np.column_stack([np.clip((command - first) / (full - first), 0.0, 1.0) for first, full in edges])
