from polydraulic.flow.layout.model import exact_flow
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.stepping.engine import engine_of
from polydraulic.simulation.stepping.setup import set_up
from polydraulic.simulation.stepping.text import lanes_module, places_of
from polydraulic.simulation.stepping.tip_load import as_loads


def test_machines_that_differ_in_numbers_alone_share_their_drivers(loader):
    heavy = loader._replace(links=tuple(link._replace(mass=1.1 * link.mass) for link in loader.links))
    one, other = (engine_of(set_up(machine, "exact", 5e-3, (), as_loads(None)), 0.0) for machine in (loader, heavy))
    assert one.advance is other.advance
    assert one.of != other.of
    modules = []
    for machine in (loader, heavy):
        ready = prepare_layout(machine, 5e-3)
        parts = {"valves": ready.valves, "plant": ready.plant}
        modules.append(lanes_module(machine, ready.module, parts, force=False, flow=exact_flow(machine)))
    assert modules[0] is modules[1]


def test_places_follow_each_other(loader):
    free, pushed = places_of(loader, force=False), places_of(loader, force=True)
    assert free.n_record == len(columns_of(loader).columns)
    assert free.n_out == free.n_record + 3 + 4  # the tip, two pressures of each function
    assert pushed.taken - pushed.given == free.taken - free.given + 3
    assert free.n_flag == 8 * 2 + len(loader.circuits)
