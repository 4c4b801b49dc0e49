"""Flows of valves in series at many points, with their exact slopes over each conductance and each port pressure.

The slopes of a circuit take what a spool adds to the flow through each orifice as a source. A source that only the inlets have, then
one that only the bypasses have, gives the slopes over the conductances themselves.
"""

from functools import cache
from types import ModuleType
from typing import NamedTuple

import numpy as np

from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.circuits.series.check import UNPROVED
from polydraulic.machine.circuits.series.slopes_text import SERIES_SLOPES_IMPORTS, series_slopes_text
from polydraulic.machine.circuits.series.text import SERIES_IMPORTS, series_text
from polydraulic.machine.circuits.wording import each
from polydraulic.machine.pump import Pump

_IMPORTS = (
    "import numpy as np",
    "from polydraulic._kernel import driver, kernel",
    "from polydraulic.machine.pump import Pump",
    "from polydraulic.machine.circuits.series.short import series_1, series_2",
    "from polydraulic.machine.circuits.series.short_slopes import series_1_slopes, series_2_slopes",
    "from polydraulic.machine.valve import Orifices",
)


class CircuitSlopes(NamedTuple):
    """Flows of a circuit of n valves at points, and how they change.

    Attributes
    ----------
    q_in : (n_point, n) array, m3/s
    by_inlet, by_bypass : (n_point, n, n) array, Pa^0.5
        Of each inlet flow over the conductance of each valve's inlet and bypass.
    by_pressure : (n_point, n, n) array, m3/s/Pa
        Over each port pressure.
    q_relief : (n_point,) array, m3/s
    p_pump : (n_point,) array, Pa
    solved : (n_point,) array of bool
        Where the equations are proved to be solved.
    """

    q_in: np.ndarray
    by_inlet: np.ndarray
    by_bypass: np.ndarray
    by_pressure: np.ndarray
    q_relief: np.ndarray
    p_pump: np.ndarray
    solved: np.ndarray


def circuit_slopes_at(k_in: np.ndarray, k_bypass: np.ndarray, p_in: np.ndarray, pump: Pump) -> CircuitSlopes:
    """Flows of valves in series, and their slopes.

    Parameters
    ----------
    k_in, k_bypass : (n_point, n) array, m3/s/Pa^0.5
        Conductances of n valves, counted from the pump, 1 to 6.
    p_in : (n_point, n) array, Pa
        At the pressurised ports.
    pump : Pump
    """
    points, n = p_in.shape
    found = np.empty((points, n + 3 * n * n + 3))
    k_in, k_bypass, p_in = (np.ascontiguousarray(x, dtype=np.float64) for x in (k_in, k_bypass, p_in))
    _module(n).slopes(k_in, k_bypass, p_in, pump, found)
    parts = [found[:, n + i * n * n : n + (i + 1) * n * n].reshape(points, n, n) for i in range(3)]
    return CircuitSlopes(
        found[:, :n], parts[0], parts[1], parts[2], found[:, -3], found[:, -2], found[:, -1] < UNPROVED
    )


@cache
def _module(n: int) -> ModuleType:
    imports = list(_IMPORTS)
    text: list[str] = []
    if n > 2:
        imports += [line for line in (*SERIES_IMPORTS, *SERIES_SLOPES_IMPORTS) if "_kernel import" not in line]
        text += [series_text(n), series_slopes_text(n)]
    parts = ['"""Slopes of a circuit at many points."""', "\n".join(dict.fromkeys(imports)), *text, _driver(n)]
    return loaded("\n\n\n".join(part.strip() for part in parts) + "\n")


def _driver(n: int) -> str:
    pairs = [(i, j) for i in range(1, n + 1) for j in range(1, n + 1)]
    k = each("k_~", 1, n)

    def put(first: int, name: str) -> str:
        return "\n".join(f"        found[i, {first + at}] = {name}_{i}_{j}" for at, (i, j) in enumerate(pairs))

    return f'''
@driver
def slopes(k_in: np.ndarray, k_bypass: np.ndarray, p: np.ndarray, pump: Pump, found: np.ndarray) -> None:
    """Inlet flows; slopes over inlets, bypasses and port pressures; flow of the relief valve, pressure of the pump, status."""
    inlet = Orifices(1.0, 0.0, 0.0)
    bypass = Orifices(0.0, 1.0, 0.0)
    for i in range(p.shape[0]):
{chr(10).join(f"        k_{m} = Orifices(k_in[i, {m - 1}], k_bypass[i, {m - 1}], 0.0)" for m in range(1, n + 1))}
        s = series_{n}({k}, {", ".join(f"p[i, {m}]" for m in range(n))}, pump)
        by_inlet = series_{n}_slopes({k}, {", ".join(["inlet"] * n)}, s, pump)
        by_bypass = series_{n}_slopes({k}, {", ".join(["bypass"] * n)}, s, pump)
{chr(10).join(f"        found[i, {m - 1}] = s.q_in_{m}" for m in range(1, n + 1))}
{put(n, "by_inlet.by_x")}
{put(n + n * n, "by_bypass.by_x")}
{put(n + 2 * n * n, "by_inlet.by_p")}
        found[i, {n + 3 * n * n}] = s.circuit.q_relief
        found[i, {n + 3 * n * n + 1}] = s.circuit.p_pump
        found[i, {n + 3 * n * n + 2}] = s.status
'''
