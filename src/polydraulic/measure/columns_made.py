"""Columns that nobody measured and that are made of others: flows and rates, as the channel map asks for them."""

from dataclasses import dataclass

# what becomes of what, differentiated
RATES = {
    "m": "m/s",
    "rad": "rad/s",
    "m/s": "m/s2",
    "rad/s": "rad/s2",
    "m3": "m3/s",
}


@dataclass(frozen=True)
class FlowChannel:
    """A flow that nobody measured, from the motion of its actuator; see `polydraulic.measure.flows`.

    Attributes
    ----------
    name : str
    position : str
        Column of a stroke (m) or an angle (rad).
    area : float, m2 or m3/rad
    pressure : str or None
        Column of the pressure in the line; None leaves the compliance term out.
    compliance : float, m3/Pa
    window : float, s
        Of the differentiation.
    role : str
    """

    name: str
    position: str
    area: float
    pressure: str | None = None
    compliance: float = 0.0
    window: float = 0.1
    role: str = "output"


@dataclass(frozen=True)
class RateChannel:
    """A rate that nobody measured, by differentiating a column over a window; see `polydraulic.measure.smoothing`.

    Attributes
    ----------
    name, of : str
        Columns of the rate, and of what is differentiated.
    window : float, s
    role : str
    """

    name: str
    of: str
    window: float
    role: str = "output"
