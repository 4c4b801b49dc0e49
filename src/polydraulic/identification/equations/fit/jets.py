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

_CLOSED = 1e-3  # of the widest outlet, below which the flow tells nothing


def jets_of(
    machine: LayoutMachine,
    circuit: SupplyCircuit,
    signals: dict[str, Signals],
    segment: np.ndarray,
    errors: dict[str, dict[str, np.ndarray]],
) -> dict[str, Jets]:
    """Jets of the valves of a circuit whose spools and pressures are measured.

    Parameters
    ----------
    machine : LayoutMachine
        With the curves as they are known.
    circuit : SupplyCircuit
    signals : dict from function to Signals
    segment : (n_row,) array
    errors : dict from function to dict
        Standard errors of its curves at their knots; none of those that are given.
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
    inlet = circuit_slopes_at(k_in, k_bypass, p_in, pump).q_in ** 2 / k_in
    found, rng = {}, np.random.default_rng(0)
    for k, (name, v, s) in enumerate(zip(circuit.functions, valves, of, strict=True)):
        k_out = _outlet(v, spool[:, k], v.outlet_positive, v.outlet_negative)
        outlet, again = (
            _outlet_jet(k_out, np.maximum(p - machine.tank.return_pressure, 0.0), q, s.noise)
            for p, q in ((p_out[:, k], s.values.get("q_out")), _once_more(p_out[:, k], s, segment, rng))
        )
        parts = {
            "inlet": inlet[:, k],
            "outlet_positive": outlet * forward[:, k],
            "outlet_negative": outlet * ~forward[:, k],
        }
        place = np.array([np.interp(np.abs(spool[:, k]), v.knots, one) for one in np.eye(len(v.knots))])
        off = [place * _share(v, key, errors[name][key])[:, None] * parts[key] for key in parts if name in errors]
        unsure = np.concatenate([np.empty((0, len(spool))), *off])
        own = inlet[:, k] + outlet, unsure[unsure.any(axis=1)], again - outlet
        found[name] = Jets(*(at_rows(known, values) for values in own))
    return found


def _share(valve: ValveCurves, key: str, error: np.ndarray) -> np.ndarray:
    """Errors of a curve at its knots as shares of it, of one at most; none where they are not known."""
    return np.asarray(np.minimum(np.nan_to_num(error) / np.maximum(getattr(valve, key), 1e-300), 1.0))


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


def _outlet_jet(k_out: np.ndarray, drop: np.ndarray, q_out: np.ndarray | None, noise: dict[str, float]) -> np.ndarray:
    """From drop and flow, weighed by what noise makes of each."""
    by_drop = k_out * drop
    if q_out is None:
        return by_drop
    open_ = k_out > _CLOSED * k_out.max(initial=1e-300)
    wide = np.where(open_, k_out, 1.0)
    told, q_out = open_ & np.isfinite(q_out), np.nan_to_num(q_out)
    by_flow = q_out * np.abs(q_out) / wide
    of_flow = (2.0 * np.maximum(np.abs(q_out), noise["q_out"]) * noise["q_out"] / wide) ** 2
    of_drop = (k_out * _noise_of_pressure(noise)) ** 2
    share = np.where(told, of_drop / (of_drop + of_flow + 1e-300), 0.0)
    return np.asarray(by_drop + share * (by_flow - by_drop))
