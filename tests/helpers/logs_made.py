"""A log as a machine could have made it, and what can be wrong with one."""

import numpy as np

from polydraulic.measure import import_log, load_channels

RASTER = 0.01


MAP = """
raster = "10 ms"

[[channel]]
source = "time"
role = "time"
unit = "s"
raster = "10 ms"

[[channel]]
source = "lever"
role = "input"
unit = "V"
range = [-1.2, 1.2]

[[channel]]
source = "p_head"
name = "boom.p_a"
role = "input"
unit = "bar"
raster = "10 ms"
range = [5, 250]

[[channel]]
source = "speed"
role = "output"
unit = "mm/s"
raster = "20 ms"
"""


UNITS = {"time": "s", "lever": "V", "p_head": "bar", "speed": "mm/s"}


def healthy(seed=0, n=4000):
    """Columns of a log with noise: a lever that moves and rests, a pressure, a speed at every other row."""
    rng = np.random.default_rng(seed)
    time = RASTER * np.arange(n)
    level = np.repeat(rng.uniform(-1.0, 1.0, n // 80 + 1) * (rng.random(n // 80 + 1) < 0.6), 80)[:n]
    smooth = np.convolve(np.concatenate([np.zeros(20), level]), np.full(21, 1 / 21), mode="valid")
    lever = np.round(smooth + rng.normal(0.0, 0.004, n), 3)
    opening = np.sign(smooth) * np.maximum(np.abs(smooth) - 0.25, 0.0)
    p_head = np.round(90.0 + 60.0 * opening + 15.0 * np.sin(0.7 * time) + rng.normal(0.0, 0.5, n), 1)
    speed = np.where(np.arange(n) % 2 == 0, 300.0 * opening + rng.normal(0.0, 3.0, n), np.nan)
    return {"time": np.round(time, 6), "lever": lever, "p_head": p_head, "speed": np.round(speed, 2)}


def write_csv(path, columns, names=None, units=UNITS):
    """Write columns of numbers or texts; NaN is an empty cell. `names` replaces the header."""
    heads = names or [f"{name} [{units[name]}]" if units.get(name) else name for name in columns]
    cells = [[x if isinstance(x, str) else "" if x != x else repr(float(x)) for x in c] for c in columns.values()]
    lines = [",".join(heads), *(",".join(row) for row in zip(*cells, strict=True))]
    path.write_text("\n".join(lines) + "\n")
    return path


def imported(tmp_path, columns, channel_map=MAP, names=None, units=UNITS, change=lambda text: text):
    log = write_csv(tmp_path / "log.csv", columns, names, units)
    log.write_text(change(log.read_text()))
    (tmp_path / "map.toml").write_text(channel_map)
    return import_log(log, load_channels(tmp_path / "map.toml"), tmp_path / "table.parquet")


def lose(columns, rows):
    return {name: np.delete(values, rows) for name, values in columns.items()}


def put(columns, name, rows, value):
    changed = columns[name].astype(object) if isinstance(value, str) else columns[name].copy()
    changed[rows] = value
    return {**columns, name: changed}
