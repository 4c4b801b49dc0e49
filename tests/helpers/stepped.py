"""The compiled loop of a machine over given voltages."""

import numpy as np

from polydraulic.flow.dispatch import layout_flow
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout


def stepped(machine, flow, voltage, locked=(), dt=5e-3):
    """Recorded rows, (n_step + 1, n_column), and how many steps did not converge or left the domain."""
    model = layout_flow(flow, machine)
    ready, of = prepare_layout(machine, dt, locked, flow=model), columns_of(machine, stores_oil=model.stores_oil)
    rows, counts = np.empty((len(voltage) + 1, len(of.columns))), np.zeros(2, dtype=np.int64)
    voltage = np.ascontiguousarray(voltage, dtype=np.float64)
    done = ready.module.run(ready.valves, np.zeros(ready.n_memory), ready.plant, ready.start, voltage, 1, rows, counts)
    assert done == len(voltage)
    return rows, counts
