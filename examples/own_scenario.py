"""Drive the machine by joystick voltages of your own: arrays become a recording, a recording is a scenario."""

import numpy as np

from polydraulic import Table, simulate, write_table

time = np.linspace(0.0, 4.0, 81)
lever = 0.6 * np.clip(time - 0.5, 0.0, 1.0) * (time < 3.0)  # V: out within a second, held, let go at 3 s
columns = {"time": time, "swing": 0.0 * time, "boom": lever, "stick": 0.0 * time}
write_table(Table.from_dict(columns, {"time": "s", "swing": "V", "boom": "V", "stick": "V"}), "recording.csv")

run = simulate("cat215b", "exact", "recording.csv", raster=0.05)
raised = np.degrees(run["boom.angle"][-1] - run["boom.angle"][0])
print(f"the boom went up by {raised:.1f} deg, its spool as far as {1e3 * run['boom.spool'].max():.1f} mm")

# a positive lever raises the boom; a second after it was let go the valve is shut
assert raised > 5.0
assert run["boom.q_in"].max() > 0.0
assert run["boom.q_in"][-1] == 0.0
