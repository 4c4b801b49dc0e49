"""Smooth motion of a machine's joints, and pressures that give it: what sensors would read, without a simulation."""

import numpy as np

from polydraulic.identification.equations.mechanics.inertia import (
    inertial_numbers,
    inertial_values,
    torque_regressor,
)
from polydraulic.identification.equations.mechanics.motion_rows import oil_torques
from polydraulic.simulation.layout.columns import function_column
from polydraulic.tables import Table


def motion_log(machine, seconds=60.0, raster=0.02, late=0.0, noise=0.0, seed=0):
    """Positions that are sums of sines, and pressures whose torques move the masses and overcome friction."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds / raster)) * raster
    position, rate, acceleration, then, rate_then, acceleration_then = (
        np.zeros((len(time), len(machine.functions))) for _ in range(6)
    )
    for k, f in enumerate(machine.functions):
        low = max(f.stops.low, -1.0)  # some stops are further away than any machine turns
        high = min(f.stops.high, low + 1.5)
        parts = [(0.1 * (high - low), 2.0 * np.pi * rng.uniform(0.1, 0.5), rng.uniform(0, 6)) for _ in range(4)]
        for t, q, w, a in ((time, position, rate, acceleration), (time - late, then, rate_then, acceleration_then)):
            q[:, k] = 0.5 * (low + high)
            for size, omega, phase in parts:
                q[:, k] += size * np.sin(omega * t + phase)
                w[:, k] += size * omega * np.cos(omega * t + phase)
                a[:, k] -= size * omega**2 * np.sin(omega * t + phase)
    numbers = inertial_numbers(machine)
    regressor = torque_regressor(machine, numbers, then, rate_then, acceleration_then, machine.gravity)
    torque = regressor @ inertial_values(machine, numbers)
    for k, f in enumerate(machine.functions):
        own, w = f.friction, rate_then[:, k]
        dry = own.coulomb + (own.static - own.coulomb) * np.exp(-((w / own.stribeck) ** 2))
        torque[:, k] += dry * np.tanh(w / own.smoothing) + own.viscous * w
    one, none = np.ones_like(position), np.zeros_like(position)
    lever_a, lever_b = oil_torques(machine, then, one, none), -oil_torques(machine, then, none, one)
    low = 1e6
    p_a = np.maximum(low, (torque + lever_b * low) / lever_a)
    p_b = (lever_a * p_a - torque) / lever_b
    columns = {"time": time}
    units = {"time": "s"}
    for k, f in enumerate(machine.names):
        column = function_column(machine, f, "angle", "rad")
        columns[column.name] = position[:, k] + noise * 5e-4 * rng.normal(size=len(time))
        units[column.name] = column.unit
        for name, values in (("p_a", p_a), ("p_b", p_b)):
            columns[f"{f}.{name}"] = values[:, k] + noise * 1e5 * rng.normal(size=len(time))
            units[f"{f}.{name}"] = "Pa"
    return Table(columns, units)
