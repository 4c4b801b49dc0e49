"""How curves of a valve go on beyond the travel that a log has: by what was known before, bounded and monotone."""

import numpy as np

_LAST = 0.25  # of the travel behind the deadband, over which a bypass shows how it falls
_SHUTS = 0.1  # of the way from the last travel of the log to where a bypass is known to be shut, in which it shuts


def beyond(knots: np.ndarray, values: np.ndarray, old_knots: np.ndarray, old: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values behind the last knot: the old curve's shape, scaled to meet; where the old one is shut, no less than the last."""
    last = float(np.interp(knots[-1], old_knots, old))
    scale = values[-1] / last if last > 0.0 else 1.0
    return np.asarray(scale * np.interp(at, old_knots, old))


def shutting(
    knots: np.ndarray, bypass: np.ndarray, old_knots: np.ndarray, old: np.ndarray, opens: float
) -> tuple[float, np.ndarray] | None:
    """How a bypass goes on that was not seen to shut: with the slope that it had, and shut where the old curve is.

    A bypass may fall evenly, or stay and then shut at once: a straight line from the log's last travel to where it is shut would be far off in
    between, and with it the pump's pressure.

    Parameters
    ----------
    knots, bypass : (m,) array
        As identified.
    old_knots, old : (n,) array
        As known before.
    opens : float, m
        Travel at which the valve opens.

    Returns
    -------
    float, m, and array
        One more knot, and the values at it and at the old knots behind the last one, in their order; None where the old curve is not known to
        shut, or is shut at the log's last travel.
    """
    last = float(knots[-1])
    behind = old_knots[old_knots > last + 1e-6]
    shut = behind[np.interp(behind, old_knots, old) <= 0.0]
    if not len(shut) or np.interp(last, old_knots, old) <= 0.0 or bypass[-1] <= 0.0 or last <= opens:
        return None
    back = last - _LAST * (last - opens)
    slope = min((float(bypass[-1]) - float(np.interp(back, knots, bypass))) / (last - back), 0.0)
    turn = shut[0] - _SHUTS * (shut[0] - last)
    if slope < 0.0:
        turn = min(turn, last - bypass[-1] / slope)
    at = np.sort(np.append(behind, turn))
    return float(turn), np.where(at >= shut[0], 0.0, np.maximum(bypass[-1] + slope * (at - last), 0.0))
