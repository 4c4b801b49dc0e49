import numpy as np
from polydraulic.machine.plant import prepare

from polydraulic.flow.lanes import LANES, at, get, get_links, get_orifices, leaves, put, put_links
from polydraulic.machine.state import Links


def test_a_value_is_found_in_its_row_and_lane():
    rows = np.zeros(5 * LANES)
    put_links(rows, 1, 7, Links(1.0, 2.0, 3.0))
    put(rows, 4, 63, 9.0)
    assert get_links(rows, 1, 7) == (1.0, 2.0, 3.0)
    assert (get(rows, 2, 7), get(rows, 4, 63)) == (2.0, 9.0)
    assert np.flatnonzero(rows).tolist() == [LANES + 7, 2 * LANES + 7, 3 * LANES + 7, 4 * LANES + 63]


def test_the_orifices_of_a_link_lie_a_quantity_apart():
    rows = np.repeat(np.arange(60.0), LANES)
    inlet, bypass, outlet = get_orifices(rows, 1, 5)
    assert (bypass - inlet, outlet - bypass) == (3.0, 3.0)


def test_a_lane_has_the_shared_parameters_or_its_own(machine):
    plants = [prepare(machine, dt, locked) for dt, locked in ((5e-3, ()), (1e-3, ("swing",)))]
    assert at(None, plants[0], 3) is plants[0]
    own = np.array([leaves(plants[lane % 2]) for lane in range(LANES)], dtype=np.float64).T.ravel()
    for lane in (0, 1, 63):
        found = at(own, plants[0], lane)
        assert found == plants[lane % 2]
        assert found.locked.swing is (lane % 2 == 1)
