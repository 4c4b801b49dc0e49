"""A machine from a log of its work: record an operator, learn pump and valves, run the machine on them against another day's log."""

from pathlib import Path

from polydraulic import random_operator
from polydraulic.identification import fit_machine, replay
from polydraulic.measure import example_sensors, import_log, load_channels, load_sensors, record

Path("sensors.toml").write_text(example_sensors())
bench = load_sensors("sensors.toml")
channel = '[[channel]]\nsource = "{}"\nunit = "{}"\nrole = "input"\n'
channels = [channel.format(sensor.column, sensor.unit) for sensor in bench.sensors]
Path("map.toml").write_text("\n".join(['raster = "20 ms"', *channels]))
for day, seed, seconds in (("monday", 1, 900.0), ("tuesday", 5, 200.0)):
    record("cat215b", [random_operator(seed, seconds)], bench, f"{day}.mf4")
    import_log(f"{day}.mf4", load_channels("map.toml"), f"{day}.parquet")

learnt = fit_machine("monday.parquet")
found = replay("tuesday.parquet", models=learnt.models)
print(found)
for drift in found.drifts:
    assert drift.median < 0.05 * drift.moved  # no orifice area was known
