"""The whole machine as an FMU, run by another tool: FMPy moves the boom as `simulate` does. Needs `pip install fmpy`."""

import fmpy
import numpy as np

from polydraulic import load_machine, load_scenario, simulate
from polydraulic.export import export_machine_fmu

machine, scenario, dt = load_machine("cat215b"), load_scenario("sine"), 5e-3
export_machine_fmu(machine, "exact", "excavator.fmu", version=3, dt=dt)

time = np.arange(0.0, 4.0, dt)
volts = scenario.voltages(time)
inputs = np.array([tuple(row) for row in np.column_stack([time, volts])], dtype=[(name, float) for name in (
    "time", "swing.voltage", "boom.voltage", "stick.voltage")])  # fmt: skip
result = fmpy.simulate_fmu(
    "excavator.fmu", stop_time=4.0, step_size=dt, output_interval=dt, input=inputs, output=["boom.angle", "stick.angle"]
)
run = simulate(machine, "exact", scenario, dt=dt, t_end=4.0)
apart = max(np.abs(result[name] - run[name]).max() for name in ("boom.angle", "stick.angle"))
print(f"joint angles are at most {np.degrees(apart):.1e} deg apart")
assert np.degrees(np.ptp(run["boom.angle"])) > 1.0  # something moved
assert apart < 1e-9
