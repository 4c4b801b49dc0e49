import numpy as np

from polydraulic.flow import exact_flow
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links, State
from polydraulic.simulation.solvers.right_hand_side import held_at_stops, rates, resting


def test_stops_hold_what_they_push(machine):
    """Of boom and stick at their lower stops: for random line pressures the choice satisfies every stop."""
    plant, model, rng = prepare(machine, 1.0), exact_flow(machine), np.random.default_rng(3)
    low = Links(0.0, machine.boom.stops.low, machine.stick.stops.low)
    seen = set()
    for _ in range(100):
        p_a, p_b = (Links(*rng.uniform(0.0, 3e7, 3)) for _ in range(2))
        x = State(Links(0.0, 0.0, 0.0), p_a, p_b, low, Links(rng.uniform(-1.0, 1.0), 0.0, 0.0))
        rest = resting(x, 0.0, plant)
        held = held_at_stops(rest, x, rates(model, np.zeros(1), plant, rest, x), plant)
        r = rates(model, np.zeros(1), plant, held, x)
        for place in (1, 2):
            assert (r.reaction[place] if held[place] else r.acceleration[place]) >= -1e-6
        seen.add((held.boom, held.stick))
    assert len(seen) == 4
