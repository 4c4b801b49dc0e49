"""What the driver is told of tipping: the margins of the monitor, a warning a second ahead, and where to."""

import numpy as np
import pytest

from polydraulic import Simulator, StabilityMonitor, load_machine
from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.description import machine_description
from polydraulic.cockpit.protocol import Flag
from polydraulic.cockpit.tipping import EVERY, HELD, SEEN, Tipping
from polydraulic.cockpit.wanted import Wanted

FREE = Wanted(locked=False)
LIGHT = {"chassis.mass": 5000.0, "functions.lift.initial.angle": 0.6}


def columns(cab):
    return dict(zip((c.name for c in cab.view.columns), np.frombuffer(cab.shown.values, "<f4").tolist(), strict=True))


def test_a_driver_is_warned_a_second_ahead_and_told_where_to():
    """A light loader lowers a heavy load from above, which takes it outward."""
    light = load_machine("wheel_loader").with_values(LIGHT)
    cab, told, soon = Cab(light), {}, -1000
    lower = FREE._replace(payload=1000.0)
    for k in range(500):
        cab.move(lower._replace(axes=(0.0, 0.0, 0.0, 0.45 if k > 100 else 0.0, 0.0, 0.0)), 2)
        seen = columns(cab)
        warned = bool(cab.shown.flags & Flag.TIPPING)
        soon = k if seen["tipping.time"] <= 2.0 else soon
        assert warned == (k - soon < HELD // 2)
        for _, (at, where, what) in cab.shown.events:
            if where == "chassis":
                told[what] = at
        if "tips forward" in told:
            break
    assert told["tips forward"] - told["may tip forward"] >= 1.0
    assert seen["tipping.dynamic_distance"] <= 0.0
    assert seen["tipping.edge"] == 0.0


def test_a_guarded_driver_is_slowed():
    """The same load, lowered by coordinated control, with the guard and without."""
    light, least = load_machine("wheel_loader").with_values(LIGHT | {"chassis.mass": 5500.0}), {}
    for guarded in (True, False):
        cab = Cab(light)
        cab.warm_up()
        assert machine_description(cab)["coordinated"]["guard"] == {"able": True, "why": "", "margin": 0.2}
        lower = FREE._replace(payload=1000.0, mode="coordinated", guarded=guarded)
        cab.move(lower, 300)
        distance, shares = [], []
        for _ in range(200):
            cab.move(lower._replace(axes=(0.0, 0.0, 0.0, 0.5, 0.0, 0.0)), 10)
            seen = columns(cab)
            distance.append(seen["tipping.distance"])
            shares.append(seen["tipping.guard"])
            assert bool(cab.shown.flags & Flag.GUARDED) == (seen["tipping.guard"] < 1.0)
        least[guarded] = min(distance)
        assert shares[0] == 1.0
        assert (min(shares) < 0.25) == guarded
        assert (set(shares) == {1.0}) != guarded
        cab.move(lower._replace(mode="joint"), 10)
        assert not cab.shown.flags & Flag.GUARDED
    assert least[True] > 0.18 > 0.12 > least[False]


def test_a_machine_without_chassis_has_no_guard():
    cab = Cab(load_machine("wheel_loader")._replace(chassis=None))
    cab.warm_up()
    guard = machine_description(cab)["coordinated"]["guard"]
    assert not guard["able"]
    assert "[chassis]" in guard["why"]
    cab.move(FREE._replace(mode="coordinated", guarded=True, axes=(0.0, 0.0, 0.0, -0.4, 0.0, 0.0)), 60)
    assert not cab.shown.flags & Flag.GUARDED
    assert columns(cab)["lift.voltage"] != 0.0


def test_what_is_seen_is_what_the_monitor_says():
    cab = Cab("wheel_loader")
    cab.move(FREE._replace(axes=(0.0, 0.0, 0.0, -0.7, 0.0, 0.0), payload=800.0), EVERY)
    found, seen = StabilityMonitor("wheel_loader", dt=DT)(cab.simulator, payload=800.0), columns(cab)
    assert seen["tipping.distance"] == pytest.approx(found.distance.min(), rel=1e-6)
    assert seen["tipping.dynamic_distance"] == pytest.approx(found.dynamic_distance.min(), rel=1e-6)
    assert (seen["tipping.gravity_x"], seen["tipping.gravity_y"]) == pytest.approx(tuple(found.gravity), rel=1e-6)
    chassis = machine_description(cab)["chassis"]
    assert chassis["edges"] == ["forward", "left", "rear", "right"]
    assert chassis["most"] == pytest.approx(1.0)  # half of its gauge


def test_it_is_looked_at_now_and_then_and_after_a_change():
    with Simulator("wheel_loader", load={"payload": 0.0}) as simulator:
        tipping = Tipping(simulator)
        assert tipping.look(0.0)
        simulator.step({}, n=EVERY - 1)
        assert not tipping.look(0.0)
        simulator.change({"tank.return_pressure": 3e5})
        assert tipping.look(0.0)  # numbers count
        tipping.forget()
        assert tipping.look(0.0)


def test_a_machine_without_chassis_is_driven_without():
    cab = Cab(load_machine("wheel_loader")._replace(chassis=None))
    assert cab.tipping is None
    assert not any(c.name in dict(SEEN) for c in cab.view.columns)
    assert machine_description(cab)["chassis"] is None
