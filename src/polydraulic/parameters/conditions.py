"""Conditions between several numbers of a machine."""

from math import pi, sin
from typing import Any


def broken_conditions(machine: Any) -> list[str]:
    """Say which conditions a `Machine`, whose class asks for this, does not meet; each number by itself lies in its range."""
    broken: list[str] = []

    def require(good: bool, key: str, value: object, allowed: str) -> None:
        if not good:
            broken.append(f"{key} = {value}: must be {allowed}")

    spool, pumps, tank = machine.spool, machine.pumps, machine.tank
    rising = all(a < b for a, b in zip(spool.knots, spool.knots[1:], strict=False)) and spool.knots[0] == 0.0
    require(rising, "spool.knots", spool.knots, "rising from 0 m")
    for key in ("deadband", "bypass_closed"):
        require(
            getattr(spool, key) in spool.knots,
            f"spool.{key}",
            getattr(spool, key),
            f"one of the knots {spool.knots}",
        )
    require(spool.deadband < spool.bypass_closed, "spool.deadband", spool.deadband, "below spool.bypass_closed")
    require(pumps.relief > tank.return_pressure, "pumps.relief", pumps.relief, "above tank.return_pressure")
    for name in ("swing", "boom", "stick"):
        link = getattr(machine, name)
        shut = [k <= spool.deadband for k in spool.knots]
        for key in ("inlet", "outlet_positive", "outlet_negative"):
            table = getattr(link.valve, key)
            closed = all(v == 0.0 for v, s in zip(table, shut, strict=True) if s)
            require(closed, f"{name}.valve.{key}", table, "0 up to spool.deadband")
        open_ends = [v for v, k in zip(link.valve.bypass, spool.knots, strict=True) if k >= spool.bypass_closed]
        require(not any(open_ends), f"{name}.valve.bypass", link.valve.bypass, "0 from spool.bypass_closed on")
        friction, stops, start, relief = link.friction, link.stops, link.initial, link.line.relief
        require(
            friction.static >= friction.coulomb,
            f"{name}.friction.static",
            friction.static,
            "at least coulomb",
        )
        require(stops.low < stops.high, f"{name}.stops.low", stops.low, "below stops.high")
        require(stops.low <= start.angle <= stops.high, f"{name}.initial.angle", start.angle, "within the stops")
        require(relief > tank.return_pressure, f"{name}.line.relief", relief, "above tank.return_pressure")
        for key in ("p_a", "p_b"):
            value = getattr(start, key)
            require(
                tank.floor <= value <= relief,
                f"{name}.initial.{key}",
                value,
                f"in [{tank.floor:g}, {relief:g}] Pa",
            )
    for name, sign in (("boom", 1.0), ("stick", -1.0)):
        link = getattr(machine, name)
        cylinder = link.cylinder
        require(cylinder.rod < cylinder.bore, f"{name}.cylinder.rod", cylinder.rod, "below the bore")
        ends = [sign * angle + cylinder.angle_offset for angle in link.stops]
        turned = all(0.0 < angle < pi and sin(angle) > 0.0 for angle in ends)
        require(
            turned,
            f"{name}.cylinder.angle_offset",
            cylinder.angle_offset,
            "so that the triangle never folds flat",
        )
    return broken
