"""Circuits of valves in series, generated, with loops over states; and states of all kinds."""

import importlib.util
import sys
from functools import cache
from pathlib import Path

import numpy as np

from helpers.valves import circuit_pump, orifices
from polydraulic.machine.circuits.series.text import SERIES_IMPORTS, series_text

FOLDER = Path(__file__).parents[1] / "__pycache__" / "series"  # stays, so that compiled kernels are found again
IMPORTS = "\n".join(
    (
        "import numpy as np",
        *SERIES_IMPORTS,
        "from polydraulic._kernel import driver",
        "from polydraulic.machine.pump import Pump",
        "from polydraulic.machine.valve import Orifices",
    )
)


def listed(pattern, n):
    return ", ".join(pattern.format(i=i, j=i + 1) for i in range(n))


def _loops(n):
    """Loops over rows of states: solved, repaired alone, and in the pieces that lanes use."""
    valves = f"{listed('Orifices(inlets[i, {i}], bypasses[i, {i}], 0.0)', n)}, {listed('ports[i, {i}]', n)}, pump"
    stores = "\n".join(f"    out[i, {i}] = s.q_in_{i + 1}" for i in range(n))
    between = "\n".join(f"    out[i, {n + 5 + i}] = s.p_between_{i + 1}" for i in range(n - 1))
    loop = "(inlets, bypasses, ports, pump, out):\n    for i in range(inlets.shape[0]):\n"
    return f"""

@kernel
def put(s: Series{n}, i: int, out: np.ndarray) -> None:
{stores}
    out[i, {n}] = s.circuit.q_bypass
    out[i, {n + 1}] = s.circuit.q_pump
    out[i, {n + 2}] = s.circuit.q_relief
    out[i, {n + 3}] = s.circuit.p_pump
    out[i, {n + 4}] = s.status
{between}


@driver
def solve_all{loop}        put(series_{n}({valves}), i, out)


@driver
def repair_all{loop}        put(series_{n}_repair({valves}), i, out)


@driver
def pass_all{loop}        path, x = series_{n}_path({listed("Orifices(inlets[i, {i}], bypasses[i, {i}], 0.0)", n)}), series_{n}_begin(pump)
        for _ in range(PASSES):
            x = series_{n}_limit_pass(x, path, {listed("ports[i, {i}]", n)}, pump)
        put(series_{n}_limit_end(x, path, {valves}), i, out)
"""


def made(name, text):
    """Module of a text; its file is written where it differs."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.py"
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@cache
def series(n):
    """Kernels of `n` valves with loops over states; those of these fill rows of `n + 5 + n - 1` numbers."""
    return made(f"made_series_{n}", f"{IMPORTS}\n\n\n{series_text(n)}{_loops(n)}")


def solved(loop, states, pump):
    """Rows of what a loop gives."""
    n = states[0].shape[1]
    out = np.zeros((len(states[0]), 2 * n + 4))
    loop(*states, pump, out)
    return out


def pump_of(machine, exponent, relief=None):
    """The machine's pump of two functions, with a torque limit of this exponent unless that is 0."""
    limit = {"torque_limit_enabled": exponent > 0.0, "torque_limit_exponent": exponent or 1.0}
    return circuit_pump(machine, "series", relief=relief, **limit)


def real(machine, n, size, rng):
    """Orifices of the machine's valves at random spools, more often where they open; ports anywhere up to relief."""
    knots = np.array(machine.functions[0].valve.knots)
    x = rng.uniform(0.0, knots[-1], (size, n))
    x = np.where(rng.random((size, n)) < 0.4, rng.uniform(knots[1], knots[4], (size, n)), x)
    tables = [machine.functions[j % 3].valve for j in range(n)]
    k = np.array([[orifices(x[i, j], tables[j])[:2] for j in range(n)] for i in range(size)])
    ports = rng.uniform(0.0, machine.circuit("boom").pump.relief, (size, n))
    return np.ascontiguousarray(k[:, :, 0]), np.ascontiguousarray(k[:, :, 1]), ports


def hard(machine, n, size, rng):
    """Conductances over six decades, a tenth of them shut."""
    inlets, bypasses = 10.0 ** rng.uniform(-11.0, -5.0, (2, size, n))
    inlets, bypasses = (np.where(rng.random((size, n)) < 0.1, 0.0, k) for k in (inlets, bypasses))
    return inlets, bypasses, rng.uniform(0.0, machine.circuit("boom").pump.relief, (size, n))


def edges(machine, n, size, rng):
    """Just opening orifices, dead ends, equal ports, ports at return, relief and limit pressure or a rounding away."""
    any_real, any_hard = real(machine, n, size, rng), hard(machine, n, size, rng)
    chosen = rng.random((size, 1)) < 0.3
    inlets, bypasses = (np.where(chosen, h, r) for h, r in zip(any_hard[:2], any_real[:2], strict=True))
    just = rng.random((size, n))
    inlets = np.where(just < 0.15, inlets * 10.0 ** rng.uniform(-9.0, -2.0, (size, n)), inlets)
    bypasses = np.where(just > 0.85, bypasses * 10.0 ** rng.uniform(-9.0, -2.0, (size, n)), bypasses)
    bypasses = np.where(rng.random((size, n)) < 0.1, 0.0, bypasses)
    back, relief = machine.tank.return_pressure, machine.circuit("boom").pump.relief
    special = [0.0, back, relief, 0.999999 * back, 1.000001 * back, machine.circuit("boom").pump.torque_limit_start]
    ports = np.where(rng.random((size, n)) < 0.4, rng.choice(special, (size, n)), any_real[2])
    for j in range(1, n):
        near = ports[:, j - 1] * rng.choice([1.0, 1.0, 1.0 + 1e-15, 1.0 - 1e-12, 1.0 + 1e-9], size)
        ports[:, j] = np.where(rng.random(size) < 0.3, near, ports[:, j])
    return inlets, bypasses, ports


STATES = {"real": real, "hard": hard, "edges": edges}
