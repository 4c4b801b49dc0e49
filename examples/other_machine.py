"""A machine with other values: how much more pressure holds a boom that is heavier by a tonne?"""

import numpy as np

from polydraulic import Scenario, load_machine, simulate

machine = load_machine("cat215b")
heavier = machine.with_values({"links.boom.mass": machine.link("boom").mass + 1000.0})  # kg; values are SI

rest = Scenario("rest", 10.0, voltage={}, locked=("swing", "stick"))  # nobody touches a lever
light, heavy = (simulate(m, "exact", rest, raster=0.1) for m in (machine, heavier))


def load(run):
    """Net pressure force of both cylinders at the end of a run, N."""
    c = machine.function("boom").drive
    head, ring = c.number * np.pi / 4.0 * c.bore**2, c.number * np.pi / 4.0 * (c.bore**2 - c.rod**2)
    return run["boom.p_a"][-1] * head - run["boom.p_b"][-1] * ring


print(f"head side: {light['boom.p_a'][-1] / 1e5:.0f} bar, with a tonne more {heavy['boom.p_a'][-1] / 1e5:.0f} bar")
assert abs(heavy["boom.rate"][-1]) < 1e-3  # it stands
assert load(heavy) > load(light) > 0.0
assert np.allclose(light["swing.angle"], light["swing.angle"][0])  # a locked link stays where it is
