"""Equations of motion at every row of a log whose positions and pressures are both noisy: errors in variables.

A row's equation joins readings of five positions, so that rows err together, by what noise of positions and pressures makes of them. They are
weighed by the inverse of that covariance, which is banded, and linearised about the motion that agrees with readings, equations and present numbers
best, not about readings: a noisy rate in a regressor would make what it is multiplied by too small, and friction near rest most of all (Britt and Luecke,
Technometrics 15 (1973) 233). This comes to the least that noise allows of the rows that are taken; `motion_rows` is where it begins from.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky_banded
from scipy.linalg.lapack import dtbtrs

from polydraulic.identification.equations.mechanics.base_parameters import BaseParameters
from polydraulic.identification.equations.mechanics.inertia import torque_regressor
from polydraulic.identification.equations.mechanics.motion_rows import (
    Piece,
    clear_of_stops,
    friction_regressor,
    oil_torques,
    raster_of_piece,
    rate_noise,
    smoothed,
    steady,
)
from polydraulic.identification.noise import robust_deviation
from polydraulic.parameters.layout.schema import LayoutMachine

_AT = np.arange(-2, 3)  # rows of a stencil, about the one whose equation it is
_QUARTIC = np.linalg.inv(np.vander(_AT, increasing=True).astype(float))  # its coefficients, of five positions
_CHUNK = 4096  # rows: matrices of a chunk stay small
_HIT = 0.01  # rad/s or m/s: who is so fast at a stop is brought to rest by an impulse, which all joints feel
_SURE = 3.0  # standard deviations of a rate at rest
_FINEST = 1e-6  # of the largest torque: noise of dead sensors, or at a dead centre
_MEAN, _BLOCK = 0.3, 2.0  # s: over which residuals are averaged, and over which they may go together
_ROBUST = 2.0  # standard deviations of such a mean, from which on its rows count less
_STEP = 1e-4  # rad/s or m/s, of the difference that friction has for its slope


class NoisyRows(NamedTuple):
    """What blocks of time say about the numbers that they were linearised at.

    Attributes
    ----------
    gram : (n_block, n, n) array
        Information on base parameters, coulomb, static and viscous friction of each function, and by how much pressures are late.
    pull : (n_block, n) array
        Towards other numbers: information times the step that a block asks for.
    """

    gram: np.ndarray
    pull: np.ndarray


class _Chunk:
    """Readings that follow each other, and the motion that is thought to be behind them."""

    def __init__(self, piece: Piece, late: np.ndarray, motion: np.ndarray, raster: float, shift: int) -> None:
        self.read, self.motion = piece.position, motion  # (n_row + 4, n_function)
        time, self.p_a, self.p_b, self.late = (v[2:-2] for v in (piece.time, piece.p_a, piece.p_b, late))
        self.raster, self.shift = raster, shift
        self.block = (time // _BLOCK).astype(int)
        self.mean = np.unique((time // _MEAN).astype(int), return_inverse=True)[1]
        self.known = np.zeros(self.late.shape, dtype=bool)
        self.inertia = np.zeros((*self.late.shape, self.late.shape[1]))
        self.oil_variance, self.looser = np.ones((2, *self.late.shape))
        self.means = np.zeros(self.late.shape)  # of whitened residuals, each in its own standard deviations


class NoisyMotion:
    """The equations of motion of a log at all rows in which joints move steadily.

    Parameters
    ----------
    machine : LayoutMachine
        Its masses do not matter.
    base : BaseParameters
    own : (n_number,) array
        Inertial numbers by which noise of positions counts.
    pieces : sequence of Piece
    noise : tuple of (n_function,) arrays
        Standard deviations of positions and of pressures at A and B.
    lag : float, s
        By how much pressures are late against positions, to a row or so.
    step : float, s
        As for `motion_rows`.

    Attributes
    ----------
    spread : (n_function,) array
        Robust standard deviation of what is left of mean torques, of what noise makes of them.
    """

    def __init__(
        self,
        machine: LayoutMachine,
        base: BaseParameters,
        own: np.ndarray,
        pieces: Sequence[Piece],
        noise: tuple[np.ndarray, np.ndarray, np.ndarray],
        lag: float,
        step: float,
    ) -> None:
        self.machine, self.base, self.noise, self.step = machine, base, noise, step
        self.to_own = np.linalg.pinv(base.combine)
        self.chunks = [c for piece in pieces if len(piece.time) > 1 for c in self._chunks(piece, own, lag)]
        self.spread = np.ones(len(machine.functions))

    def _chunks(self, piece: Piece, own: np.ndarray, lag: float) -> list[_Chunk]:
        """Chunks of a piece, pressures beside the positions that they belong to."""
        raster = raster_of_piece(piece)
        shift = round(lag / raster)
        ahead, behind = max(shift, 0), max(-shift, 0)
        count, reach = len(piece.time) - ahead - behind, len(_AT) - 1
        if count <= 2 * reach:
            return []
        motion = smoothed(piece.position, raster)[0]
        rates = [smoothed(p, raster)[1] for p in (piece.p_a, piece.p_b)]
        late = -oil_torques(self.machine, motion, *rates)[ahead : ahead + count]
        motion = motion[behind : behind + count]
        time, p_a, p_b = (v[ahead : ahead + count] for v in (piece.time, piece.p_a, piece.p_b))
        beside = Piece(time, piece.position[behind : behind + count], p_a, p_b)
        found = []
        for first in range(0, count - reach, _CHUNK):
            of = slice(first, first + _CHUNK + reach)
            found.append(_Chunk(Piece(*(v[of] for v in beside)), late[of], motion[of], raster, shift))
            self._begin(found[-1], own)
        return found

    def _begin(self, chunk: _Chunk, own: np.ndarray) -> None:
        """What does not change: rows that are taken, the mass matrix, and variances that noise of pressures makes."""
        machine, (_, sd_a, sd_b) = self.machine, self.noise
        q, w, _ = _derivatives(chunk.motion, _stencil(0.0), chunk.raster)
        hit = np.maximum(_HIT, _SURE * rate_noise(chunk.raster) * self.noise[0])
        chunk.known = steady(machine, q, w) & ~_struck(machine, chunk.read[2:-2], np.abs(w) > hit)[:, None]
        none = np.zeros_like(q)
        for k in range(q.shape[1]):
            once = none.copy()
            once[:, k] = 1.0
            chunk.inertia[:, :, k] = torque_regressor(machine, self.base.numbers, q, none, once, 0.0) @ own
        of_a, of_b = (oil_torques(machine, q, *p) for p in ((none + sd_a, none), (none, none + sd_b)))
        least = _FINEST * np.abs(oil_torques(machine, q, chunk.p_a, chunk.p_b)).max()
        chunk.oil_variance = of_a**2 + of_b**2 + least**2

    def rows_at(self, numbers: np.ndarray) -> NoisyRows:
        """Linearise about numbers, and bring the motion nearer to what agrees with them.

        Parameters
        ----------
        numbers : (n,) array
            In the order of `NoisyRows`.
        """
        found = dict[int, np.ndarray]()
        for chunk in self.chunks:
            white = self._whitened(chunk, numbers)
            blocks, first = np.unique(chunk.block, return_index=True)
            joints = len(white) // len(chunk.block)
            for block, rows in zip(blocks.tolist(), np.split(white, joints * first[1:]), strict=True):
                found[block] = found.get(block, 0.0) + rows.T @ rows
            _average(chunk, white[:, -1].reshape(chunk.known.shape))
        self._loosen()
        gram, n = np.array([*found.values()]), len(numbers)
        return NoisyRows(gram[:, :n, :n], -gram[:, :n, n])

    def _whitened(self, chunk: _Chunk, numbers: np.ndarray) -> np.ndarray:
        """Rows and, as a last column, what is left of them, each with variance one and by itself."""
        machine, raster = self.machine, chunk.raster
        stencil = _stencil(chunk.shift - numbers[-1] / raster)
        q, w, a = _derivatives(chunk.motion, stencil, raster)
        before, n_base = w - 0.5 * self.step * a, len(self.base.texts)
        rows = np.concatenate(
            [
                torque_regressor(machine, self.base.numbers, q, before, a, machine.gravity) @ self.to_own,
                friction_regressor(machine, before),
                chunk.late[:, :, None],
            ],
            axis=-1,
        )
        left = rows[:, :, :-1] @ numbers[:-1] - oil_torques(machine, q, chunk.p_a, chunk.p_b)
        ahead, behind = (friction_regressor(machine, before + way) for way in (_STEP, -_STEP))
        slope = (ahead - behind) @ numbers[n_base:-1] / (2.0 * _STEP)
        known, sd = chunk.known, self.noise[0]
        every = np.arange(len(machine.functions))
        of_motion = chunk.inertia[:, :, None, :] * (stencil[2] / raster**2)[:, None]
        of_motion[:, every, :, every] += slope.T[:, :, None] * (
            stencil[1] / raster - 0.5 * self.step * stencil[2] / raster**2
        )
        of_motion *= known[:, :, None, None]
        off, count = chunk.read - chunk.motion, len(known)
        left += sum(np.einsum("tik,tk->ti", of_motion[:, :, j], off[j : count + j]) for j in range(len(_AT)))
        left, rows = np.where(known, left, 0.0), rows * known[:, :, None]
        band = _covariance(of_motion * sd, np.where(known, chunk.oil_variance * chunk.looser, 1.0))
        triangle = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        both = np.concatenate([rows, left[:, :, None]], axis=-1).reshape(-1, len(numbers) + 1)
        white = dtbtrs(triangle, both, uplo="L")[0]
        force = dtbtrs(triangle, white[:, -1:], uplo="L", trans="T")[0].reshape(known.shape)
        chunk.motion = chunk.read.copy()
        for j in range(len(_AT)):
            chunk.motion[j : count + j] -= sd**2 * np.einsum("tik,ti->tk", of_motion[:, :, j], force)
        return np.asarray(white)

    def _loosen(self) -> None:
        """Rows of which more is left than noise makes count less: all of a function, and those far off."""
        n = len(self.machine.functions)
        left = [chunk.means * np.sqrt(chunk.looser) for chunk in self.chunks]
        self.spread = np.array(
            [
                robust_deviation(
                    np.concatenate([of[chunk.known[:, k], k] for of, chunk in zip(left, self.chunks, strict=True)])
                )
                for k in range(n)
            ]
        )
        least = np.maximum(self.spread, 1.0)
        for chunk, of in zip(self.chunks, left, strict=True):
            chunk.looser = least**2 * np.maximum(1.0, np.abs(of) / (_ROBUST * least))

    def noise_of_means(self) -> np.ndarray:
        """Standard deviation that noise of pressures makes of such a mean torque, (n_function,) in N m or N."""
        each = [chunk.oil_variance * chunk.raster / _MEAN for chunk in self.chunks]
        return np.asarray(np.sqrt(np.median(np.concatenate(each), axis=0)))


def _stencil(at: float) -> np.ndarray:
    """Weights of five positions for position, rate and acceleration, at a place in rows from the middle one; (3, 5)."""
    power = np.arange(len(_AT))
    value = float(at) ** power
    rate = power * np.concatenate([[0.0], value[:-1]])
    return np.asarray(np.array([value, rate, power * np.concatenate([[0.0], rate[:-1]])]) @ _QUARTIC)


def _derivatives(motion: np.ndarray, stencil: np.ndarray, raster: float) -> list[np.ndarray]:
    """Position, rate and acceleration at the rows of a chunk."""
    count = len(motion) - 4
    return [
        sum(weight * motion[j : count + j] for j, weight in enumerate(of)) / raster**k for k, of in enumerate(stencil)
    ]


def _struck(machine: LayoutMachine, position: np.ndarray, fast: np.ndarray) -> np.ndarray:
    """Rows near which any joint runs into its stop, by positions as they were read: a filter makes them late there."""
    hit = np.any(fast & ~clear_of_stops(machine, position), axis=1)
    reach = len(_AT) // 2 + 1
    return np.convolve(hit, np.ones(2 * reach + 1))[reach : reach + len(hit)] > 0.0


def _covariance(of_motion: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Of rows that follow each other, as a lower band: by their slopes over positions in standard deviations, and variances of their own."""
    count, n = own.shape
    band = np.zeros((len(_AT) * n, count * n))
    for later in range(min(len(_AT), count)):
        pairs = np.einsum(
            "tijk,tljk->til",
            of_motion[later:, :, : len(_AT) - later],
            of_motion[: count - later, :, later:],
            optimize=True,
        )
        for i in range(n):
            for k in range(n):
                if (below := later * n + i - k) >= 0:
                    band[below, k : (count - later) * n : n] = pairs[:, i, k]
    band[0] += own.ravel()
    return band


def _average(chunk: _Chunk, left: np.ndarray) -> None:
    """Means of whitened residuals over a while, in standard deviations."""
    sums, counts = np.zeros((2, chunk.mean.max() + 1, left.shape[1]))
    np.add.at(sums, chunk.mean, left)
    np.add.at(counts, chunk.mean, chunk.known)
    chunk.means = (sums / np.sqrt(np.maximum(counts, 1.0)))[chunk.mean]
