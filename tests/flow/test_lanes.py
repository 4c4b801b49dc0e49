import numpy as np

from polydraulic.flow.lanes import LANES, at, leaves
from polydraulic.simulation.layout.prepare import prepare_layout


def test_a_lane_has_the_shared_parameters_or_its_own(machine):
    plants = [prepare_layout(machine, dt, locked).plant for dt, locked in ((5e-3, ()), (1e-3, ("swing",)))]
    assert at(None, plants[0], 3) is plants[0]
    own = np.array([leaves(plants[lane % 2]) for lane in range(LANES)], dtype=np.float64).T.ravel()
    for lane in (0, 1, 63):
        found = at(own, plants[0], lane)
        assert found == plants[lane % 2]
        assert found.locked.swing is (lane % 2 == 1)
