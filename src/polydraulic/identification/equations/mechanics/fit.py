"""Masses and friction from pressures and positions: the oil's torques, and the machine nearest to what was known.

The rows of `motion_rows` are linear in inertial numbers and friction: from them it begins. Those of `noisy_motion`, which take noise of positions
for what it is, are linearised about what was found, three times over. What rows say stands in one matrix and one vector; numbers of the machine file are
found such that they fit these and stay near their priors, so that what the motion does not determine stays where it was.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from polydraulic.errors import InputError
from polydraulic.identification.arguments import table_of
from polydraulic.identification.doubts.torques import check_torques
from polydraulic.identification.equations.mechanics.base_parameters import BaseParameters, base_parameters
from polydraulic.identification.equations.mechanics.inertia import inertial_values
from polydraulic.identification.equations.mechanics.motion_rows import (
    FRICTION,
    MotionRows,
    measured_pieces,
    motion_rows,
)
from polydraulic.identification.equations.mechanics.noisy_motion import NoisyMotion, NoisyRows
from polydraulic.identification.equations.mechanics.weight_widths import sensor_noise, weight_widths
from polydraulic.identification.equations.numbers.estimates import (
    Estimates,
    correlation_of,
    estimates_of,
    left_out,
)
from polydraulic.identification.equations.numbers.unbounded import (
    Unbounded,
    from_unbounded,
    slopes_of_values,
    to_unbounded,
    unbounded,
)
from polydraulic.identification.log_pieces import in_si
from polydraulic.identification.noise import robust_deviation
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of, function_column
from polydraulic.tables import Table

_LINEARISED = 3  # times, about what was found before
_PASSES = 8  # of weights that follow the residuals
_ROBUST = 2.0  # standard deviations from which on a row counts less
_LAG_SPREAD = 0.02  # s
_INERTIAL = ("mass", "cg", "inertia")
_FEW = 50  # rows
_STEP = 1e-5
_STEP_OF_RUNS = 5e-3  # s, as `simulate` has it unless told otherwise


class BaseEstimate(NamedTuple):
    """A base parameter: what it is made of, value, standard deviation, and whether the log says more than the priors did.

    The standard deviation follows from how residuals scatter. It does not hold what happens between the rows of a log: a combination that is
    small against what others add to the same torques may be off by more.
    """

    text: str
    value: float
    sd: float
    determined: bool


class MechanicsFit(NamedTuple):
    """Mechanics as a log tells them.

    Attributes
    ----------
    machine : LayoutMachine
        With the numbers that were found.
    estimates : Estimates
        Of the numbers that were free.
    base : tuple of BaseEstimate
        The combinations of masses that motion can tell.
    lag : float, s
        By how much pressures are late against positions.
    residual : tuple of float, N m or N
        Robust standard deviation of what is left of each function's mean torque over 0.3 s, in units of what noise of all sensors makes of
        that, times `noise`.
    noise : tuple of float, N m or N
        What noise of pressures makes of such a mean torque.
    torque : tuple of float, N m or N
        Root of the mean square of the torque itself.
    """

    machine: LayoutMachine
    estimates: Estimates
    base: tuple[BaseEstimate, ...]
    lag: float
    residual: tuple[float, ...]
    noise: tuple[float, ...]
    torque: tuple[float, ...]


def mechanical_spreads(machine: LayoutMachine, share: float = 0.5) -> dict[str, float]:
    """Standard deviations of all masses, centres of gravity, inertias and frictions: a share of what the machine's file says.

    A centre of gravity is spread by a share of its distance from the joint, a number that is zero by that of the largest of its kind.
    """
    found = {}
    for number in machine.numbers:
        kind = number.path.split(".")
        if kind[0] == "links" and kind[2] in _INERTIAL:
            like = [abs(n.value) for n in machine.numbers if n.path.startswith(".".join(kind[:3]))]
            found[number.path] = share * max(abs(number.value), 0.3 * max(like))
        elif kind[0] == "functions" and kind[2] == "friction" and kind[3] in FRICTION:
            found[number.path] = share * number.value
    return {path: spread for path, spread in found.items() if spread > 0.0}


def fit_mechanics(
    log: Table | str | Sequence[Table | str],
    machine: LayoutMachine,
    spreads: Mapping[str, float] | None = None,
    *,
    step: float = _STEP_OF_RUNS,
) -> MechanicsFit:
    """Find masses, centres of gravity, inertias and friction from pressures and positions.

    Parameters
    ----------
    log : Table or its file
        ``time`` and, of every function, ``NAME.angle`` (``NAME.position`` of a joint that slides), ``NAME.p_a`` and ``NAME.p_b``, in SI.
    machine : LayoutMachine
        With what is known: sizes of cylinders, pins, and numbers that are the means of priors.
    spreads : mapping from path to standard deviation, SI, optional
        Of the numbers that are to be found; `mechanical_spreads` if not given.
    step : float, s
        With which `simulate` is to repeat the log with the numbers that are found; none for those of motion without steps, which differ where
        viscous friction over half a step is not small against a joint's own inertia.

    Returns
    -------
    MechanicsFit

    Raises
    ------
    InputError
        Missing columns, a step that is negative or not finite, friction that holds or play (which the linear equations do not have), no piece that is
        long enough, joints that never move steadily, torques of the oil that do not go with motion.
    """
    if not 0.0 <= step < np.inf:
        raise InputError(f"step = {step!r} s: must be none or positive, and finite, for example 0.005")
    held = [f.name for f in machine.functions if f.effects.sticks or f.effects.backlash is not None]
    if held:
        raise InputError(
            f"functions.{held[0]}: friction that holds and play are not linear; identify it through simulation"
        )
    wanted = [
        name
        for f in machine.names
        for name in (function_column(machine, f, "angle", "rad").name, f"{f}.p_a", f"{f}.p_b")
    ]
    table, source = table_of(log, [], ["time", "segment", *wanted])
    missing = [name for name in ["time", *wanted] if name not in table.names]
    if missing:
        raise InputError(
            f"{source}: no column {missing[0]!r}; masses are identified from positions and both pressures of every function"
        )
    in_si(table, {column.name: column.unit for column in columns_of(machine).columns} | {"time": "s"})
    check_torques(machine, table)
    numbers = unbounded(machine, mechanical_spreads(machine) if spreads is None else spreads)
    base = base_parameters(machine)
    pieces = measured_pieces(machine, table)
    widths = weight_widths(machine, base.numbers, pieces)
    rows = motion_rows(machine, base.numbers, pieces, widths, step)
    if rows.known.sum() < _FEW:
        raise InputError(
            f"{source}: joints move steadily in {rows.known.sum()} rows only; masses and friction need {_FEW} at least"
        )
    unknowns = _Unknowns(machine, numbers, base)
    x = unknowns.nearest(*_regression(rows), np.append(to_unbounded(numbers, numbers.start), 0.0))
    at = unknowns.linear(x)
    motion = NoisyMotion(machine, base, at[: len(base.numbers)], pieces, sensor_noise(pieces), at[-1], step)
    combine = block_diag(base.combine, np.eye(len(at) - len(base.numbers)))  # friction and lag are as they are
    for _ in range(_LINEARISED):
        at = unknowns.linear(x)
        told = motion.rows_at(combine @ at)
        information = combine.T @ told.gram.sum(0) @ combine
        x = unknowns.nearest(information, information @ at + combine.T @ told.pull.sum(0), x)
    return _found(unknowns, x, told, motion, _sizes(rows))


def _regression(rows: MotionRows) -> tuple[np.ndarray, np.ndarray]:
    """Information and right side of rows as they are. Weights follow residuals: those far off count less, and each function by its deviation."""
    n, known = rows.torque.shape[1], rows.known
    deviation = np.array([robust_deviation(rows.torque[known[:, k], k]) for k in range(n)])
    length = np.sqrt(np.einsum("tkc,tkc->c", rows.regressor, rows.regressor))
    length = np.where(length > 0.0, length, 1.0)
    scaled, far = rows.regressor / length, np.zeros(known.shape)
    for _ in range(_PASSES):
        weight = known / deviation**2 / np.maximum(1.0, far / _ROBUST)
        information = np.einsum("tkc,tk,tkd->cd", scaled, weight, scaled, optimize=True)
        right = np.einsum("tkc,tk->c", scaled, weight * rows.torque)
        x = np.linalg.lstsq(information, right, rcond=1e-12)[0]
        off = scaled @ x - rows.torque
        deviation = np.array([robust_deviation(off[known[:, k], k]) for k in range(n)])
        far = np.abs(off) / deviation
    both = np.outer(length, length)
    return information * both, right * length


def _sizes(rows: MotionRows) -> np.ndarray:
    """Root mean squares of the oil's torques in the rows that count, (n_function,)."""
    return np.asarray(np.sqrt((rows.torque**2 * rows.known).sum(0) / np.maximum(rows.known.sum(0), 1)))


class _Unknowns:
    """The numbers that are free and the lag of pressures, as one vector without bounds, and what rows are linear in."""

    def __init__(self, machine: LayoutMachine, numbers: Unbounded, base: BaseParameters) -> None:
        self.machine, self.numbers, self.base = machine, numbers, base

    def linear(self, x: np.ndarray) -> np.ndarray:
        """Inertial numbers, friction and lag."""
        values = dict(zip(self.numbers.paths, from_unbounded(self.numbers, x[:-1]).tolist(), strict=True))
        friction = [
            values.get(f"functions.{f.name}.friction.{name}", getattr(f.friction, name))
            for f in self.machine.functions
            for name in FRICTION
        ]
        inertial = inertial_values(_moved(self.machine, values), self.base.numbers)
        return np.concatenate([inertial, friction, [x[-1] * _LAG_SPREAD]])

    def nearest(self, information: np.ndarray, right: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Numbers that fit what the log says and stay near their priors."""
        square, numbers = _root(information), self.numbers
        aim = np.linalg.lstsq(square.T, right, rcond=1e-12)[0]

        def residual(x: np.ndarray) -> np.ndarray:
            prior = (from_unbounded(numbers, x[:-1]) - numbers.start) / numbers.spread
            return np.concatenate([square @ self.linear(x) - aim, prior, x[-1:]])

        return np.asarray(least_squares(residual, start, method="trf", max_nfev=60, x_scale=1.0).x)


def _found(
    unknowns: _Unknowns, found: np.ndarray, told: NoisyRows, motion: NoisyMotion, torque: np.ndarray
) -> MechanicsFit:
    """What comes of it, with standard deviations."""
    machine, numbers, base = unknowns.machine, unknowns.numbers, unknowns.base
    to_base = base.combine
    own = slopes_of_values(numbers, found[:-1])
    slopes = _slopes(unknowns.linear, found)[:, :-1] @ np.linalg.inv(own)  # of the linear unknowns over values
    slopes = np.column_stack([slopes, np.eye(len(slopes))[-1]])  # of the lag itself
    prior = np.diag(1.0 / np.append(numbers.spread, _LAG_SPREAD) ** 2)
    n = len(base.numbers)
    of_base = np.concatenate([to_base @ slopes[:n], slopes[n:]])
    gram = of_base.T @ told.gram @ of_base
    seen = gram.sum(0)
    inverse = np.linalg.inv(seen + prior)
    covariance = left_out(gram, told.pull @ of_base, prior) + inverse @ prior @ inverse
    values = from_unbounded(numbers, found[:-1])
    estimates = estimates_of(
        numbers.paths,
        values,
        covariance[:-1, :-1],
        numbers.spread,
        correlation_of(seen[:-1, :-1], numbers.spread),
    )
    there = machine.with_values(dict(zip(numbers.paths, values.tolist(), strict=True)))
    to_values = to_base @ slopes[:n, :-1]
    sd = np.sqrt(np.einsum("ij,jk,ik->i", to_values, covariance[:-1, :-1], to_values))
    before = np.sqrt(np.einsum("ij,j,ij->i", to_values, numbers.spread**2, to_values))
    made = to_base @ inertial_values(there, base.numbers)
    told_base = tuple(
        BaseEstimate(text, float(value), float(own_sd), bool(own_sd < 0.5 * prior_sd))
        for text, value, own_sd, prior_sd in zip(base.texts, made, sd, before, strict=True)
    )
    noise = motion.noise_of_means()
    return MechanicsFit(
        there,
        estimates,
        told_base,
        float(found[-1] * _LAG_SPREAD),
        tuple((motion.spread * noise).tolist()),
        tuple(noise.tolist()),
        tuple(torque.tolist()),
    )


def _root(information: np.ndarray) -> np.ndarray:
    """A matrix whose square is the information, (n, n), without what rounding made negative."""
    scale = np.sqrt(np.diagonal(information))
    scale = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    return np.asarray((np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T) * scale)


def _moved(machine: LayoutMachine, values: Mapping[str, float]) -> LayoutMachine:
    """The machine with other masses, whether they are possible or not: `with_values` looks at all numbers, which takes long."""
    links = []
    for link in machine.links:
        where = f"links.{link.name}"
        cg = {c: values.get(f"{where}.cg.{c}", value) for c, value in link.cg.items()}
        inertia = {key: values.get(f"{where}.inertia.{key}", value) for key, value in link.inertia.items()}
        links.append(link._replace(mass=values.get(f"{where}.mass", link.mass), cg=cg, inertia=inertia))
    return machine._replace(links=tuple(links))


def _slopes(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    """By central differences, (n_value, n_x)."""
    steps = _STEP * np.eye(len(x))
    return np.column_stack([(function(x + step) - function(x - step)) / (2.0 * _STEP) for step in steps])
