"""cat215b as links, functions and circuits: each method does what its form written by hand does."""

import numpy as np
import pytest

from helpers.three_links import as_links
from polydraulic import load_machine, simulate
from polydraulic.parameters.schema import LINKS

# largest differences of angles in rad; the reference chooses its steps by its own errors
LIMITS = {"semi-implicit": 1e-12, "rk4": 1e-12, "rosenbrock": 1e-12, "reference": 1e-9}


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["task", "step", "pulse"])
def test_methods_are_those_written_by_hand(scenario):
    older = load_machine("cat215b")
    links = as_links(older)
    for method, limit in LIMITS.items():
        t_end = 4.0 if scenario == "pulse" or method == "reference" else None  # later, at stops, rounding decides
        hand, found = (simulate(machine, "exact", scenario, method=method, t_end=t_end) for machine in (older, links))
        assert found.names == hand.names
        angles = [np.abs(found[f"{link}.angle"] - hand[f"{link}.angle"]).max() for link in LINKS]
        assert max(angles) < limit, method
        assert [event[1:] for event in found.info["events"]] == [event[1:] for event in hand.info["events"]]
        for count in ("steps", "steps_rejected", "events_located"):
            assert found.info.get(count) == hand.info.get(count), method
