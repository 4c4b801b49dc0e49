"""Inlet and bypass curves of the valves of a circuit, and numbers of its pump, from the flows into its actuators.

Damped Gauss-Newton steps with exact slopes: rises of curves stay at or above zero, so that inlets never fall and bypasses never rise; knots
move, but not past each other. Rows are weighted by what noise of flows, spools and pressures makes of a flow there, which the slopes say, and
rows that are far off count less (Huber). The number of steps is bounded.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_slopes_at import circuit_slopes_at
from polydraulic.identification.equations.fit.valve_curves import (
    Curves,
    Place,
    at_place,
    falling,
    placed_among,
    rising,
)
from polydraulic.identification.equations.fit.weighing import add_squares, weigh
from polydraulic.identification.equations.observations import mean_weights
from polydraulic.machine.pump import Pump

LEADS = ("lead", "lead_position")
_FLOOR = 1e-9  # of the widest conductance: a closed orifice would have no slope
_ROUNDING = 1e-12  # of the widest: what rounding leaves of an orifice that a step shuts
_NEAREST = 0.3  # of the distance to the next knot that a knot moves in a step
_CHUNK = 2048
_DIFFERENCE = 1e-4  # relative, for slopes over numbers of the pump


class CircuitRows(NamedTuple):
    """What sensors say of a circuit of n valves, in windows of rows over which flows are averaged; of a single row where they are measured.

    Attributes
    ----------
    travel : (n_window, n_long, n) array, m
    p_in : (n_window, n_long, n) array, Pa
        At the pressurised ports.
    p_rate : (n_window, n_long, n) array, Pa/s
        How fast these change.
    q_in : (n_window, n) array, m3/s
        Measured, mean of the window.
    q_rates : (n_window, n, 2) array, m3/s2
        How these change with the clocks of the sensors of pressure and of position.
    known : (n_window, n) array of bool
        Which of them count.
    block : (n_window,) array of int
        Block of time.
    noise_travel, noise_pressure, noise_flow : (n,) array
        Standard deviations.
    noise_scale : (n,) array
        Standard errors of the scales of travel, relative: all rows of a function share it.
    """

    travel: np.ndarray
    p_in: np.ndarray
    p_rate: np.ndarray
    q_in: np.ndarray
    q_rates: np.ndarray
    known: np.ndarray
    block: np.ndarray
    noise_travel: np.ndarray
    noise_pressure: np.ndarray
    noise_flow: np.ndarray
    noise_scale: np.ndarray

    def some(self, keep: np.ndarray | slice) -> "CircuitRows":
        """Those windows."""
        return self._replace(
            **{
                name: getattr(self, name)[keep]
                for name in ("travel", "p_in", "p_rate", "q_in", "q_rates", "known", "block")
            }
        )


class CircuitModel(NamedTuple):
    """Curves of the valves, counted from the pump, the pump, and by how many seconds sensors of pressure and of position are behind others."""

    valves: tuple[Curves, ...]
    pump: Pump
    lead: float = 0.0
    lead_position: float = 0.0


class Prior(NamedTuple):
    """What was known before, of curves as functions of travel and of the pump: values and how far they may be off."""

    model: CircuitModel
    spread: float  # of a curve, as a share of its value
    pump: dict[str, float]  # spread of each free number of the pump, and of each lead, SI


class Normal(NamedTuple):
    """Squares and slopes at a model: over values at knots and places of knots of each valve, then numbers of the pump."""

    loss: float
    gradient: np.ndarray
    curvature: np.ndarray


def fit_circuit(
    model: CircuitModel, rows: CircuitRows, prior: Prior, steps: int, *, knots_move: bool = True
) -> tuple[CircuitModel, float]:
    """Model nearest to the rows, and half its weighted squares; at most `steps` steps."""
    now, damping = normal(model, rows, prior), 1e-3
    for _ in range(steps):
        better = False
        for _ in range(6):
            trial = stepped_model(model, now, prior, damping, knots_move)
            found = normal(trial, rows, prior)
            if found.loss < now.loss:
                better = True
                break
            damping *= 8.0
        if not better:
            break
        gained = now.loss - found.loss
        model, now, damping = trial, found, max(damping * 0.2, 1e-9)
        if gained < 1e-5 * found.loss:
            break
    return model, now.loss


def conductances(model: CircuitModel, places: list[Place]) -> tuple[np.ndarray, np.ndarray]:
    """Of inlets and bypasses, (n_row, n) each."""
    found = []
    for curve in ("inlet", "bypass"):
        widest = max(float(getattr(v, curve).max()) for v in model.valves) or 1e-9
        found.append(
            np.maximum(
                np.column_stack([at_place(getattr(v, curve), p) for v, p in zip(model.valves, places, strict=True)]),
                _FLOOR * widest,
            )
        )
    return found[0], found[1]


def flows_of(model: CircuitModel, travel: np.ndarray, p_in: np.ndarray) -> np.ndarray:
    """Flows into the actuators, (n_row, n) in m3/s."""
    places = [placed_among(v.knots, travel[:, i]) for i, v in enumerate(model.valves)]
    return circuit_slopes_at(*conductances(model, places), p_in, model.pump).q_in


def mean_flows(model: CircuitModel, rows: CircuitRows) -> np.ndarray:
    """The same as means of windows, (n_window, n)."""
    n = len(model.valves)
    p_in = np.maximum(rows.p_in + model.lead * rows.p_rate, 0.0).reshape(-1, n)
    flows = flows_of(model, rows.travel.reshape(-1, n), p_in).reshape(rows.travel.shape)
    return np.einsum("wln,l->wn", flows, mean_weights(rows.travel.shape[1]))


def measured_flows(model: CircuitModel, rows: CircuitRows) -> np.ndarray:
    """What sensors say of these means, with their clocks as the model has them, (n_window, n)."""
    return np.asarray(rows.q_in + rows.q_rates @ (model.lead, model.lead_position))


def normal(model: CircuitModel, rows: CircuitRows, prior: Prior) -> Normal:
    """Squares and slopes over all rows, and what was known before."""
    count = 3 * sum(len(v.knots) for v in model.valves) + len(prior.pump)
    loss, gradient, curvature, used = 0.0, np.zeros(count), np.zeros((count, count)), np.empty(count, dtype=np.int64)
    for begin in range(0, len(rows.travel), _CHUNK):
        for off, slopes in weighted(model, rows.some(slice(begin, begin + _CHUNK)), list(prior.pump)):
            loss += add_squares(off, slopes, gradient, curvature, used)
    curvature += np.tril(curvature, -1).T
    return with_prior(Normal(loss, gradient, curvature), model, prior)


def weighted(model: CircuitModel, rows: CircuitRows, of_pump: list[str]) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each valve, what is left of its flow in standard deviations, (n_window,), and the slopes of that, (n_window, n_number)."""
    n, shape = len(model.valves), rows.travel.shape[:2]
    travel, p_in, p_rate = (values.reshape(-1, n) for values in (rows.travel, rows.p_in, rows.p_rate))
    p_in = np.maximum(p_in + model.lead * p_rate, 0.0)
    places = [placed_among(v.knots, travel[:, i]) for i, v in enumerate(model.valves)]
    k_in, k_bypass = conductances(model, places)
    at = circuit_slopes_at(k_in, k_bypass, p_in, model.pump)
    steep = [
        (np.diff(c) / np.diff(v.knots))[p.left]
        for v, p in zip(model.valves, places, strict=True)
        for c in (v.inlet, v.bypass)
    ]
    by_pump = np.empty((len(travel), n, len(of_pump)))
    for k, name in enumerate(of_pump):
        if name == "lead":
            balanced = np.repeat(rows.q_rates[:, :, 0], shape[1], axis=0)
            by_pump[:, :, k] = np.einsum("rij,rj->ri", at.by_pressure, p_rate) - balanced
        elif name == "lead_position":
            by_pump[:, :, k] = -np.repeat(rows.q_rates[:, :, 1], shape[1], axis=0)
        elif name == "flow":
            # all conductances and the flow grow together: all flows do so, and no pressure changes
            by_curves = np.einsum("rij,rj->ri", at.by_inlet, k_in) + np.einsum("rij,rj->ri", at.by_bypass, k_bypass)
            by_pump[:, :, k] = (at.q_in - by_curves) / model.pump.flow
        else:
            by_pump[:, :, k] = _over_pump(model.pump, name, k_in, k_bypass, p_in, at.q_in)
    solved = np.asarray(at.solved.reshape(shape).all(axis=1))
    first = np.cumsum([0, *(3 * len(v.knots) for v in model.valves)])
    off, slopes = np.empty((n, shape[0])), np.zeros((n, shape[0], first[-1] + len(of_pump)))
    weigh(
        at.q_in, at.by_inlet, at.by_bypass, at.by_pressure, by_pump, np.column_stack([p.left for p in places]),
        np.column_stack([p.share for p in places]), np.column_stack(steep).reshape(-1, n, 2), first, mean_weights(shape[1]),
        measured_flows(model, rows),
        rows.known & solved[:, None],
        np.stack([rows.noise_travel, rows.noise_pressure, rows.noise_flow]), off, slopes,
    )  # fmt: skip
    return list(zip(off, slopes, strict=True))


def number_of(model: CircuitModel, name: str) -> float:
    """A number of the pump, or a lead."""
    return float(getattr(model if name in LEADS else model.pump, name))


def pump_with(pump: Pump, name: str, value: float) -> Pump:
    """A pump with another flow, relief setting or start of the torque limit, whose least flow follows from these."""
    found = pump._replace(**{name: value})
    if found.log_least < 0.0:
        found = found._replace(
            log_least=-found.limit_exponent * float(np.log(max(found.relief / found.limit_start, 1.0)))
        )
    return found


def _over_pump(
    pump: Pump, name: str, k_in: np.ndarray, k_bypass: np.ndarray, p_in: np.ndarray, q_in: np.ndarray
) -> np.ndarray:
    value = getattr(pump, name)
    step = _DIFFERENCE * value
    return (circuit_slopes_at(k_in, k_bypass, p_in, pump_with(pump, name, value + step)).q_in - q_in) / step


def with_prior(of: Normal, model: CircuitModel, prior: Prior) -> Normal:
    """Squares with those of what was known before: a curve's values at the knots, and numbers of the pump."""
    loss, gradient, curvature = of.loss, of.gradient.copy(), of.curvature.copy()
    at = 0
    for v, before in zip(model.valves, prior.model.valves, strict=True):
        m = len(v.knots)
        for k, curve in enumerate(("inlet", "bypass")):
            known = np.interp(v.knots, before.knots, getattr(before, curve))
            width = prior.spread * np.maximum(known, 0.1 * float(getattr(before, curve).max()))
            off = (getattr(v, curve) - known) / width
            loss += 0.5 * float(off @ off)
            part = slice(at + k * m, at + (k + 1) * m)
            gradient[part] += off / width
            curvature[part, part] += np.diag(width**-2)
        at += 3 * m
    for k, (name, width) in enumerate(prior.pump.items()):
        off_pump = (number_of(model, name) - number_of(prior.model, name)) / width
        loss += 0.5 * off_pump**2
        gradient[at + k] += off_pump / width
        curvature[at + k, at + k] += width**-2
    return Normal(loss, gradient, curvature)


def numbers_to_values(model: CircuitModel, pump: int) -> np.ndarray:
    """From rises, falls, places of inner knots and numbers of the pump to values and places at all knots."""
    parts: list[np.ndarray] = []
    for v in model.valves:
        m = len(v.knots)
        parts += [rising(m), falling(m), np.eye(m)[:, 1:-1]]
    parts.append(np.eye(pump))
    found = np.zeros((sum(p.shape[0] for p in parts), sum(p.shape[1] for p in parts)))
    row = column = 0
    for p in parts:
        found[row : row + p.shape[0], column : column + p.shape[1]] = p
        row, column = row + p.shape[0], column + p.shape[1]
    return found


def stepped_model(
    model: CircuitModel, at: Normal, prior: Prior, damping: float, knots_move: bool = True
) -> CircuitModel:
    """Model after one damped step within the bounds."""
    from scipy.optimize import lsq_linear

    to_values = numbers_to_values(model, len(prior.pump))
    g, h = to_values.T @ at.gradient, to_values.T @ at.curvature @ to_values
    scale = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
    g, h = g * scale, h * scale[:, None] * scale[None, :]
    low, high = bounds(model, len(prior.pump), knots_move)
    root = np.linalg.cholesky(h + (damping + 1e-10) * np.eye(len(g)))
    target = -np.linalg.solve(root, g)
    low, high = low / scale, high / scale
    step = lsq_linear(
        root.T, target, (np.minimum(low, -1e-300), np.maximum(high, 1e-300)), method="bvls", max_iter=200
    ).x
    return moved(model, to_values @ (step * scale), list(prior.pump))


def bounds(model: CircuitModel, pump: int, knots_move: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """How far down and up each number may go."""
    low, high = [], []
    nearest = _NEAREST if knots_move else 0.0
    for v in model.valves:
        gaps = np.diff(v.knots)
        falls = np.append(-np.diff(v.bypass), v.bypass[-1])
        low += [-np.diff(v.inlet), -falls, -nearest * gaps[:-1]]
        high += [np.full(len(gaps), np.inf), np.full(len(falls), np.inf), nearest * gaps[1:]]
    return np.concatenate([*low, np.full(pump, -np.inf)]), np.concatenate([*high, np.full(pump, np.inf)])


def moved(model: CircuitModel, step: np.ndarray, of_pump: list[str]) -> CircuitModel:
    """Model with values and places of knots moved by a step."""
    valves, at = [], 0
    for v in model.valves:
        m = len(v.knots)
        inlet, bypass, knots = (
            old + step[at + k * m : at + (k + 1) * m] for k, old in enumerate((v.inlet, v.bypass, v.knots))
        )
        inlet = np.maximum.accumulate(np.maximum(inlet, 0.0))
        bypass = np.maximum.accumulate(np.maximum(bypass, 0.0)[::-1])[::-1]
        valves.append(Curves(knots, *(np.where(k > _ROUNDING * k.max(), k, 0.0) for k in (inlet, bypass))))
        at += 3 * m
    pump, leads = model.pump, {}
    for k, name in enumerate(of_pump):
        value, change = number_of(model, name), float(step[at + k])
        if name in LEADS:
            leads[name] = value + change
        else:
            pump = pump_with(pump, name, max(value + change, 0.2 * value))
    return model._replace(valves=tuple(valves), pump=pump, **leads)
