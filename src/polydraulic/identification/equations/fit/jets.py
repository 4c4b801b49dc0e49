"""Jets of a circuit's valves, conductance times drop at inlet and outlet, which push spools back (`polydraulic.machine.play`).

Inlets: the circuit solved at measured spools and pressures. Outlets: from the drop and, where it is measured, from the flow, q^2 / K, each as
far as its sensor tells it: of a wide outlet the flow, of a narrow one the drop. Noise would shift spools to and fro, and so wear a hysteresis down.
"""

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, conductances
from polydraulic.identification.equations.fit.circuit_slopes_at import circuit_slopes_at
from polydraulic.identification.equations.fit.valve_curves import Curves, placed_among
from polydraulic.identification.equations.parabolas import local_parabolas
from polydraulic.identification.equations.pilot_fit import Jets
from polydraulic.identification.equations.sensors import AT_VALVE, Signals, at_rows, known_at_valves
from polydraulic.machine.pump import limited_pump
from polydraulic.parameters.layout.parts import SupplyCircuit, ValveCurves
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import segments_of

JET_CURVES = ("inlet", "outlet_positive", "outlet_negative")
_CLOSED = 1e-3  # of the widest outlet, below which the flow tells nothing


def jets_of(
    machine: LayoutMachine,
    circuit: SupplyCircuit,
    signals: dict[str, Signals],
    segment: np.ndarray,
    shares: dict[str, np.ndarray],
    moved: dict[str, np.ndarray],
) -> dict[str, Jets]:
    """Jets of the valves of a circuit whose spools and pressures are measured.

    Parameters
    ----------
    machine : LayoutMachine
        With the curves as they are known.
    circuit : SupplyCircuit
    signals : dict from function to Signals
    segment : (n_row,) array
    shares : dict from function to (n_number,) array
        Standard errors of its curves at their knots, `JET_CURVES` one after the other, as shares of them; none of those that are known.
    moved : dict from function to (n_number,) array
        By how many of these the curves are off already from what was known of them before.
    """
    every = [signals[name] for name in circuit.functions]
    known = known_at_valves(circuit.functions, signals, len(segment))
    of, segment = [s.at(known) for s in every], segments_of(segment, known)
    spool, p_a, p_b = (np.column_stack([s.values[what] for s in of]) for what in AT_VALVE)
    for p in (p_a, p_b):
        for k in range(len(of)):
            p[:, k] = local_parabolas(p[:, k], segment)[0]
    forward = spool > 0.0
    p_in, p_out = np.maximum(np.where(forward, p_a, p_b), 0.0), np.where(forward, p_b, p_a)
    valves = [machine.function(name).valve for name in circuit.functions]
    curves = tuple(Curves(*(np.array(part) for part in (v.knots, v.inlet, v.bypass))) for v in valves)
    pump = limited_pump(circuit.pump.flow, circuit.pump.relief, machine.tank.return_pressure, circuit.pump)
    places = [placed_among(c.knots, np.abs(spool[:, k])) for k, c in enumerate(curves)]
    k_in, k_bypass = conductances(CircuitModel(curves, pump), places)
    at = circuit_slopes_at(k_in, k_bypass, p_in, pump)
    inlet = at.q_in**2 / k_in
    found, rng = {}, np.random.default_rng(0)
    for k, (name, v, s) in enumerate(zip(circuit.functions, valves, of, strict=True)):
        k_out = _outlet(v, spool[:, k], v.outlet_positive, v.outlet_negative)
        drop = np.maximum(p_out[:, k] - machine.tank.return_pressure, 0.0)
        outlet, by_outlet = _outlet_jet(k_out, drop, s.values.get("q_out"), s.noise)
        p_again, q_again = _once_more(p_out[:, k], s, segment, rng)
        again, _ = _outlet_jet(k_out, np.maximum(p_again - machine.tank.return_pressure, 0.0), q_again, s.noise)
        by_inlet = (2.0 * at.q_in[:, k] * at.by_inlet[:, k, k] - inlet[:, k]) / k_in[:, k]
        slopes = by_inlet, by_outlet * forward[:, k], by_outlet * ~forward[:, k]
        place = np.array([np.interp(np.abs(spool[:, k]), v.knots, one) for one in np.eye(len(v.knots))])
        each = np.concatenate(
            [place * np.array(getattr(v, key))[:, None] * of for key, of in zip(JET_CURVES, slopes, strict=True)]
        )
        none = np.zeros(len(each))
        unsure = shares.get(name, none)[:, None] * each
        strength, noise = inlet[:, k] + outlet, again - outlet
        found[name] = Jets(
            at_rows(known, strength), at_rows(known, unsure), at_rows(known, noise), moved.get(name, none)
        )
    return found


def _outlet(valve: ValveCurves, spool: np.ndarray, positive: object, negative: object) -> np.ndarray:
    """Of a spool's own outlet, what is given at the knots."""
    at = np.abs(spool)
    return np.where(spool > 0.0, *(np.interp(at, valve.knots, np.asarray(values)) for values in (positive, negative)))


def _once_more(
    p_out: np.ndarray, s: Signals, segment: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray | None]:
    """Smoothed pressure and measured flow with as much noise again as they have."""
    noise = rng.normal(0.0, _noise_of_pressure(s.noise), len(p_out))
    q = s.values.get("q_out")
    q = None if q is None else q + rng.normal(0.0, s.noise["q_out"], len(p_out))
    return p_out + local_parabolas(noise, segment)[0], q


def _noise_of_pressure(noise: dict[str, float]) -> float:
    return max(noise["p_a"], noise["p_b"])


def _outlet_jet(
    k_out: np.ndarray, drop: np.ndarray, q_out: np.ndarray | None, noise: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """From drop and flow, weighed by what noise makes of each, and its slope over the conductance."""
    by_drop = k_out * drop
    if q_out is None:
        return by_drop, drop
    open_ = k_out > _CLOSED * k_out.max(initial=1e-300)
    wide = np.where(open_, k_out, 1.0)
    told, q_out = open_ & np.isfinite(q_out), np.nan_to_num(q_out)
    by_flow = q_out * np.abs(q_out) / wide
    of_flow = (2.0 * np.maximum(np.abs(q_out), noise["q_out"]) * noise["q_out"] / wide) ** 2
    of_drop = (k_out * _noise_of_pressure(noise)) ** 2
    share = np.where(told, of_drop / (of_drop + of_flow + 1e-300), 0.0)
    return by_drop + share * (by_flow - by_drop), drop - share * (drop + by_flow / wide)
