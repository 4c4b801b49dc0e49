"""From a measured log to a model: record (here on a virtual test bench), import, fit, judge on rows held out."""

from pathlib import Path

from polydraulic import AbductiveRegressor, RegionRegressor, random_operator, read_table
from polydraulic.measure import import_log, load_channels, load_sensors, record, suggest_channels

SENSORS = [("boom.spool", "mm", 0.02), ("boom.p_a", "bar", 0.3), ("boom.p_b", "bar", 0.3), ("boom.q_in", "l/min", 0.5)]
sensor = '[[sensor]]\ncolumn = "{}"\nunit = "{}"\nraster = "20 ms"\nnoise = {}\n'
Path("sensors.toml").write_text("\n".join(sensor.format(*each) for each in SENSORS))
record("cat215b", [random_operator(1, 120.0)], load_sensors("sensors.toml"), "log.csv")

Path("map.toml").write_text(suggest_channels("log.csv"))  # a first map: for a real log, go through it
imported = import_log("log.csv", load_channels("map.toml"), "table.parquet")
for finding in imported.findings:
    print(finding.level, finding)

table = read_table("table.parquet")
X, flow = table.matrix(["boom.spool", "boom.p_a", "boom.p_b"]), table["boom.q_in"]
split = int(0.8 * len(flow))  # a block of time is held out, not neighbours of rows that were seen
model = RegionRegressor(AbductiveRegressor(max_layers=2), max_regions=6).fit(X[:split], flow[:split])
r2 = model.score(X[split:], flow[split:])
print(f"{imported.n_row} rows; R2 {r2:.3f} on the last fifth of the time")
assert imported.n_row == len(flow) > 5000
assert r2 > 0.95
