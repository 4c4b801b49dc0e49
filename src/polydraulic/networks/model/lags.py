"""What makes a model dynamic: which signals it reads, and how many rows ago."""

from dataclasses import dataclass

from polydraulic.networks.model.table import UNBOUNDED


@dataclass(frozen=True)
class Lag:
    """A signal as it was `steps` rows ago; 0 is now."""

    signal: str
    steps: int

    def __str__(self) -> str:
        return f"{self.signal}[t-{self.steps}]" if self.steps else f"{self.signal}[t]"


@dataclass(frozen=True)
class JointStrength:
    """How the strength of a joint, the factor of its rate, differs from one time to another; its mean is 1.

    Attributes
    ----------
    rows : int
        Over which measured travel is compared with the model's.
    spread : float
        Standard deviation of what both ways have in common.
    lean : float
        Standard deviation of what one way has more, and the other less.
    memory : float
        Rows after which a deviation has gone down to 1/e of itself, in the mean.
    noise : float
        Variance of measured travel around the model's, for each unit of travel; in the output's unit.
    """

    rows: int
    spread: float
    lean: float
    memory: float
    noise: float


@dataclass(frozen=True)
class Dynamics:
    """What makes a model dynamic.

    Attributes
    ----------
    lags : tuple of Lag
        What each input of the model is. The model's own output is read at least one step ago.
    step : (low, high)
        The output changes by no less and no more from one row to the next.
    raster : float or None
        Time between rows in s, where it is known.
    strength : JointStrength or None
        Of a joint: how far measured rows before a run may change the factor of its rate.
    """

    lags: tuple[Lag, ...]
    step: tuple[float, float] = (-UNBOUNDED, UNBOUNDED)
    raster: float | None = None
    strength: JointStrength | None = None

    @property
    def warm_up(self) -> int:
        """Rows that must be known before the first answer."""
        return max(1, *(lag.steps for lag in self.lags))
