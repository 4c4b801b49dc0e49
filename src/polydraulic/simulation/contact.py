"""End stops for the reference solution: events of the solver, impulses, and which joints are held.

A joint is held while it stands at a stop that has to push. The solver watches two kinds of events: a free joint meets a
stop, and a held joint would have to be pulled.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links
from polydraulic.parameters import LINKS, Machine
from polydraulic.simulation.right_hand_side import landed

_NEAR = 1e-9  # rad; an event is found closer than this
_STILL = 1e-9  # rad/s

Push = Callable[[float, np.ndarray, Held], np.ndarray]


class Contact(NamedTuple):
    """Stops of the joints, the plant, and the torques that hold joints: (t, state, held) -> (3,), N m."""

    machine: Machine
    plant: Plant
    push: Push


def watch(contact: Contact, held: Held) -> list[Callable[..., float]]:
    """Events for the solver, one a link, none for locked ones: each falls through zero when its contact changes."""
    events: list[Callable[..., float]] = []
    for place, link in enumerate(LINKS):
        stops = getattr(contact.machine, link).stops

        def gap(t: float, v: np.ndarray, place: int = place, stops: Any = stops) -> float:
            return float(min(v[9 + place] - stops.low, stops.high - v[9 + place]))

        def pressed(t: float, v: np.ndarray, place: int = place, stops: Any = stops) -> float:
            return float(_side(v[9 + place], stops) * -contact.push(t, v, held)[place])

        def never(t: float, v: np.ndarray) -> float:
            return 1.0

        event: Any = never if contact.plant.locked[place] else (pressed if held[place] else gap)
        event.terminal, event.direction = True, -1.0
        events.append(event)
    return events


def impact(contact: Contact, t: float, v: np.ndarray, held: Held, which: int) -> tuple[np.ndarray, Held]:
    """State and held joints after event number `which` of `watch`."""
    if held[which]:
        freed = Held(*(h and place != which for place, h in enumerate(held)))
        return v, freed
    stops = getattr(contact.machine, LINKS[which]).stops
    v[9 + which] = stops.high if _side(v[9 + which], stops) > 0.0 else stops.low
    _stop(contact.plant, v)
    return v, held_joints(contact, t, v)


def held_joints(contact: Contact, t: float, v: np.ndarray) -> Held:
    """Which joints stand at a stop that pushes."""
    stops = [getattr(contact.machine, link).stops for link in LINKS]
    there = [
        min(v[9 + i] - stops[i].low, stops[i].high - v[9 + i]) <= _NEAR and abs(v[12 + i]) <= _STILL for i in range(3)
    ]
    for _ in range(3):  # each pass releases one joint at least, or none
        held = Held(*(bool(here or lock) for here, lock in zip(there, contact.plant.locked, strict=True)))
        push = contact.push(t, v, held)
        there = [here and _side(v[9 + i], stops[i]) * push[i] < 0.0 for i, here in enumerate(there)]
    return Held(*(bool(here or lock) for here, lock in zip(there, contact.plant.locked, strict=True)))


def _side(angle: float, stops: Any) -> float:
    return 1.0 if stops.high - angle < angle - stops.low else -1.0


@driver
def _stop(plant: Plant, v: np.ndarray) -> None:
    """Put a joint at its stop, with the impulse that this takes."""
    after = landed(Links(v[9], v[10], v[11]), Links(v[12], v[13], v[14]), plant)
    v[9], v[10], v[11] = after.angle.swing, after.angle.boom, after.angle.stick
    v[12], v[13], v[14] = after.rate.swing, after.rate.boom, after.rate.stick
