"""The history of a growth: what each layer promised, for those who draw or keep it."""

from dataclasses import dataclass
from math import nan


@dataclass(frozen=True)
class GrowthStep:
    """One layer in the history of a synthesis; errors in squared units of y."""

    layer: int
    n_candidates: int
    n_coefficients: int
    fse: float
    penalty: float
    pse: float
    accepted: bool
    leave_one_out: float = nan  # where it was asked for; of blocks where rows depend on each other
