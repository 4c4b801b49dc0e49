"""The exact circuit of any number of valves in series, at many points: what networks of it learn from."""

from collections.abc import Sequence
from functools import cache
from types import ModuleType
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.circuits.series.check import UNPROVED
from polydraulic.machine.circuits.series.text import SERIES_IMPORTS, series_text
from polydraulic.machine.circuits.wording import each
from polydraulic.machine.pump import Pump
from polydraulic.parameters.layout.parts import ValveCurves

_IMPORTS = (
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.machine.pump import Pump",
    "from polydraulic.machine.circuits.series.short import series_1, series_2",
    "from polydraulic.machine.valve import Orifices",
)


class CircuitSample(NamedTuple):
    """Flows of a circuit at points, valves along the last axis, counted from the pump."""

    q_in: np.ndarray  # (n_point, n) m3/s
    q_passed: np.ndarray  # (n_point, n) m3/s, what passes each valve; the last one's returns to the tank
    p_between: np.ndarray  # (n_point, n - 1) Pa
    q_pump: np.ndarray  # (n_point,) m3/s
    q_relief: np.ndarray  # (n_point,) m3/s
    p_pump: np.ndarray  # (n_point,) Pa


def sample_valves(
    valves: Sequence[ValveCurves], pump: Pump, travel: np.ndarray, p_in: np.ndarray, flow: np.ndarray | None = None
) -> CircuitSample:
    """Flows of valves in series.

    Parameters
    ----------
    valves : sequence of ValveCurves
        Counted from the pump, 1 to 6.
    pump : Pump
    travel : (n_point, n) array, m
        Distances of the spools from their centres.
    p_in : (n_point, n) array, Pa
        Pressures at the pressurised ports.
    flow : (n_point,) array, m3/s, optional
        Of the pump, in place of its own.

    Raises
    ------
    InputError
        If the exact equations are not proved to be solved at a point.
    """
    found, proved = solved_valves(valves, pump, travel, p_in, flow)
    unsure = np.flatnonzero(~proved)
    if unsure.size:
        where = f"travels {travel[unsure[0]].tolist()} m, pressures {p_in[unsure[0]].tolist()} Pa"
        raise InputError(f"the exact circuit is not solved at {unsure.size} of {len(travel)} points, first at {where}")
    return found


def solved_valves(
    valves: Sequence[ValveCurves], pump: Pump, travel: np.ndarray, p_in: np.ndarray, flow: np.ndarray | None = None
) -> tuple[CircuitSample, np.ndarray]:
    """`sample_valves`, and at which points the exact equations are proved to be solved, (n_point,) of bool."""
    n = len(valves)
    k_in, k_bypass = (
        np.column_stack([np.interp(travel[:, i], v.knots, getattr(v, curve)) for i, v in enumerate(valves)])
        for curve in ("inlet", "bypass")
    )
    flow = np.full(len(travel), pump.flow) if flow is None else np.ascontiguousarray(flow)
    found = np.empty((len(travel), 2 * n + 4))
    _module(n).sample(k_in, k_bypass, np.ascontiguousarray(p_in, dtype=np.float64), flow, pump, found)
    q_in, q_pump, q_relief = found[:, :n], found[:, 2 * n - 1], found[:, 2 * n + 1]
    q_passed = (q_pump - q_relief)[:, None] - np.cumsum(q_in, axis=1)
    q_passed[:, -1] = found[:, 2 * n]
    sample = CircuitSample(q_in, q_passed, found[:, n : 2 * n - 1], q_pump, q_relief, found[:, 2 * n + 2])
    return sample, found[:, -1] < UNPROVED


@cache
def _module(n: int) -> ModuleType:
    imports = [*_IMPORTS, *(line for line in SERIES_IMPORTS if n > 2 and "_kernel" not in line)]
    parts = ['"""A circuit at many points."""', "\n".join(imports), *([series_text(n)] if n > 2 else []), _driver(n)]
    return loaded("\n\n\n".join(part.strip() for part in parts) + "\n")


def _driver(n: int) -> str:
    between = "\n".join(f"        found[i, {n - 1 + k}] = s.p_between_{k}" for k in range(1, n))
    return f'''
@driver
def sample(k_in: np.ndarray, k_bypass: np.ndarray, p: np.ndarray, flow: np.ndarray, pump: Pump, found: np.ndarray) -> None:
    """Inlets, pressures between valves, flow of pump, last bypass and relief valve, pressure of the pump, status."""
    for i in range(p.shape[0]):
        fed = Pump(flow[i], pump.relief, pump.p_return, pump.limit_start, pump.limit_exponent, pump.log_least)
{chr(10).join(f"        k_{k} = Orifices(k_in[i, {k - 1}], k_bypass[i, {k - 1}], 0.0)" for k in range(1, n + 1))}
        s = series_{n}({each("k_~", 1, n)}, {", ".join(f"p[i, {k}]" for k in range(n))}, fed)
{chr(10).join(f"        found[i, {k - 1}] = s.q_in_{k}" for k in range(1, n + 1))}
{between}
        found[i, {2 * n - 1}] = s.circuit.q_pump
        found[i, {2 * n}] = s.circuit.q_bypass
        found[i, {2 * n + 1}] = s.circuit.q_relief
        found[i, {2 * n + 2}] = s.circuit.p_pump
        found[i, {2 * n + 3}] = s.status
'''
