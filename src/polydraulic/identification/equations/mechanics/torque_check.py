"""Whether torques of the oil go with motion and masses at all: with a turned sign, exchanged ports or a wrong unit they do not.

What a machine file says of masses is right within a factor of two or so, and torques that such masses need still go with those of the oil. Where they
do not, each single mistake is mended in turn, to name the one that explains it.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.motion_rows import MotionRows, Piece
from polydraulic.identification.plausible import position_column
from polydraulic.parameters.layout.schema import LayoutMachine

_LEAST, _MENDED = 0.5, 0.8  # correlations; masses and friction that are off by half leave 0.65, and mostly 0.95
_WIDEST = 5.0  # factor: pressures in another unit are off by ten at least
_FEW = 20  # rows of a function, of which fewer say nothing


class TorqueAgreement(NamedTuple):
    """How torques of the oil go with those that a machine needs, by its file; (n_function,) each, nan where a joint hardly moves.

    Attributes
    ----------
    correlation : array
        About zero, not about the mean.
    factor : array
        Of the oil's in those that are needed, by least squares.
    """

    correlation: np.ndarray
    factor: np.ndarray

    @property
    def goes(self) -> np.ndarray:
        """Where they go together, or nothing can be said."""
        fair = (self.correlation > _LEAST) & (self.factor > 1.0 / _WIDEST) & (self.factor < _WIDEST)
        return np.asarray(fair | np.isnan(self.factor))


def torque_agreement(rows: MotionRows, unknowns: np.ndarray) -> TorqueAgreement:
    """How torques go together in the rows of a log.

    Parameters
    ----------
    rows : MotionRows
    unknowns : (n,) array
        Inertial numbers and friction by the file; no lag.
    """
    needed, found = rows.regressor @ unknowns, np.full((2, rows.torque.shape[1]), np.nan)
    for k, known in enumerate(rows.known.T):
        own, oil = needed[known, k], rows.torque[known, k]
        squares = own @ own
        if known.sum() >= _FEW and squares > 0.0 and oil @ oil > 0.0:
            found[:, k] = own @ oil / np.sqrt(squares * (oil @ oil)), own @ oil / squares
    return TorqueAgreement(*found)


def check_torques(
    machine: LayoutMachine,
    pieces: Sequence[Piece],
    rows_of: Callable[[Sequence[Piece]], MotionRows],
    rows: MotionRows,
    unknowns: np.ndarray,
) -> None:
    """Refuse a log whose torques of the oil do not go with its motion.

    Parameters
    ----------
    machine : LayoutMachine
    pieces : sequence of Piece
    rows_of : function (sequence of Piece) -> MotionRows
    rows : MotionRows
        Those of the pieces.
    unknowns : (n,) array
        As for `torque_agreement`.

    Raises
    ------
    InputError
        Which function it is, and what would mend it.
    """
    found = torque_agreement(rows, unknowns)
    bad = np.flatnonzero(~found.goes)
    if not len(bad):
        return
    for k in bad.tolist():
        if found.correlation[k] > _LEAST:
            name = machine.names[k]
            raise InputError(
                f"torques of the oil at {name} are {found.factor[k]:.2g} times those that masses and friction of the file need: {name}.p_a and "
                f"{name}.p_b must be in Pa; import the log with their unit, or mend the masses of the file"
            )
    mends = []
    for k, f in enumerate(machine.functions):
        for mended, words in (
            (_exchanged, f"{f.name}.p_a and {f.name}.p_b are exchanged"),
            (_turned, f"the sign of {position_column(machine, f)} is turned"),
        ):
            try:
                other = torque_agreement(rows_of([mended(piece, k) for piece in pieces]), unknowns)
            except InputError:
                continue
            if other.goes.all() and np.all(other.correlation[[k, *bad]] > _MENDED):
                mends.append(words)
    where = ", ".join(f"{machine.names[k]} (correlation {found.correlation[k]:.2f})" for k in bad.tolist())
    advice = (
        f"they go together where {' or '.join(mends)}; mend that where the log is imported"
        if mends
        else "look at the signs of positions, at ports that are exchanged, at units of pressures, and at the masses of the file"
    )
    raise InputError(
        f"torques of the oil do not go with motion, and with what masses of the file need, at {where}: {advice}"
    )


def _exchanged(piece: Piece, k: int) -> Piece:
    """A piece with the ports of a function exchanged."""
    p_a, p_b = piece.p_a.copy(), piece.p_b.copy()
    p_a[:, k], p_b[:, k] = piece.p_b[:, k], piece.p_a[:, k]
    return piece._replace(p_a=p_a, p_b=p_b)


def _turned(piece: Piece, k: int) -> Piece:
    """A piece with the sign of a position turned."""
    position = piece.position.copy()
    position[:, k] *= -1.0
    return piece._replace(position=position)
