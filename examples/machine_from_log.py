"""A machine from a log of its work: record an operator, learn pump and valves, run the machine on them against another day."""

from pathlib import Path

from polydraulic import build_flow, load_machine, random_operator, read_table
from polydraulic.identification.log_replay import drifts, replay
from polydraulic.identification.machine_fit import Known, by_port
from polydraulic.identification.machine_judging import learn_and_judge
from polydraulic.measure import import_log, load_channels, load_sensors, record
from polydraulic.measure.bench.sensors import example_sensors

machine = load_machine("cat215b")
Path("sensors.toml").write_text(example_sensors())
bench = load_sensors("sensors.toml")
channel = '[[channel]]\nsource = "{}"\nunit = "{}"\nrole = "input"\n'
channels = [channel.format(sensor.column, sensor.unit) for sensor in bench.sensors]
Path("map.toml").write_text("\n".join(['raster = "20 ms"', *channels]))
for day, seed, seconds in (("monday", 1, 900.0), ("tuesday", 5, 200.0)):
    record(machine, [random_operator(seed, seconds)], bench, f"{day}.mf4")
    import_log(f"{day}.mf4", load_channels("map.toml"), f"{day}.parquet")

learnt = learn_and_judge(machine, by_port(Known.of(machine), read_table("monday.parquet")))
flow = build_flow("polynomial", machine, models=learnt.models)
windows = replay(machine, flow, read_table("tuesday.parquet"))
print(f"{len(windows)} windows of 10 s, each begun from the measured state:")
for drift in drifts(machine, windows):
    print(
        f"{drift.name}: {drift.median:.2f} {drift.unit} off in the median window, in which it moves by {drift.moved:.0f}"
    )
    assert drift.median < 0.05 * drift.moved  # no orifice area was known
