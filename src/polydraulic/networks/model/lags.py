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
    """

    lags: tuple[Lag, ...]
    step: tuple[float, float] = (-UNBOUNDED, UNBOUNDED)
    raster: float | None = None

    @property
    def warm_up(self) -> int:
        """Rows that must be known before the first answer."""
        return max(1, *(lag.steps for lag in self.lags))
