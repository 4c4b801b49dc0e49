"""The virtual test bench: sensors do what they say, and logs of all formats hold the same."""

import numpy as np
import pytest

from polydraulic import load_scenario
from polydraulic.errors import InputError
from polydraulic.measure import import_log, load_channels, load_sensors, record, suggest_channels
from polydraulic.measure.bench.sensors import Bench, Reading, Sensor
from polydraulic.tables import Table, read_table

RUN = Table({"time": np.arange(60_001) * 0.01, "p": np.full(60_001, 5e6)}, {"time": "s", "p": "Pa"})
SENSORS = """
seed = 3

[[sensor]]
column = "boom.spool"
unit = "mm"
raster = "10 ms"
noise = 0.02
resolution = 0.01

[[sensor]]
column = "boom.p_a"
name = "head"
unit = "bar"
raster = "10 ms"
noise = 0.3
resolution = 0.1
drift = 0.3
range = [-5, 400]

[[sensor]]
column = "boom.angle"
unit = "deg"
raster = "20 ms"
noise = 0.02
"""


def read(run=RUN, seed=0, **options):
    return Reading(Sensor("p", "p", "bar", 0.01, **options), np.random.default_rng(seed)).of(run)


def test_a_perfect_sensor_reads_the_truth():
    time, value = read()
    assert len(time) == 60_001
    assert value == pytest.approx(50.0)


def test_noise_offset_digits_and_ends():
    assert np.std(read(noise=0.5)[1]) == pytest.approx(0.5, rel=0.02)
    assert read(offset=-2.0)[1] == pytest.approx(48.0)
    value = read(noise=0.5, resolution=0.2)[1]
    assert value / 0.2 == pytest.approx(np.round(value / 0.2))
    assert np.max(read(noise=0.5, high=50.2)[1]) == 50.2
    assert np.min(read(noise=0.5, low=49.9)[1]) == 49.9


def test_drift_grows_with_the_root_of_time_and_goes_on_in_the_next_run():
    ends = []
    for seed in range(200):
        reading = Reading(Sensor("p", "p", "bar", 1.0, drift=2.0), np.random.default_rng(seed))
        first, second = reading.of(RUN)[1], reading.of(RUN)[1]
        assert abs(second[0] - first[-1]) < 0.3
        ends.append(second[-1] - 50.0)
    assert np.std(ends) == pytest.approx(2.0 * np.sqrt(1200.0 / 3600.0), rel=0.15)


def test_delay_and_lag_shift_a_ramp():
    ramp = Table({"time": RUN["time"], "p": 1e5 * RUN["time"]}, RUN.units)
    assert read(ramp, delay=0.05)[1][100:] == pytest.approx(ramp["time"][100:] - 0.05)
    assert read(ramp, lag=0.05)[1][1000:] == pytest.approx(ramp["time"][1000:] - 0.05, abs=0.006)


def test_dropouts_take_their_share_in_pieces_of_their_length():
    lost = np.isnan(read(dropout=0.1, dropout_length=0.5)[1])
    assert np.mean(lost) == pytest.approx(0.1, rel=0.2)
    pieces = np.count_nonzero(np.diff(lost.astype(int)) == 1)
    assert 0.01 * lost.sum() / pieces == pytest.approx(0.5, rel=0.25)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "sensors.toml"
    path.write_text(SENSORS)
    return load_sensors(path)


@pytest.fixture(scope="module")
def logs(tmp_path_factory, machine, bench):
    folder = tmp_path_factory.mktemp("logs")
    for ending in ("csv", "mf4", "parquet"):
        record(machine, [load_scenario("random:1:8"), load_scenario("random:2:6")], bench, folder / f"log.{ending}")
    return folder


@pytest.mark.parametrize("ending", ["csv", "mf4", "parquet"])
def test_a_recorded_log_comes_back_as_it_was(logs, tmp_path, ending):
    text = suggest_channels(logs / f"log.{ending}")
    assert text.count("[[channel]]") == (3 if ending == "mf4" else 4)
    (tmp_path / "map.toml").write_text(text)
    found = import_log(logs / f"log.{ending}", load_channels(tmp_path / "map.toml"), tmp_path / "t.parquet")
    assert {f.kind for f in found.findings} == {"gap"}  # between the runs
    assert found.n_segment == 2
    table = read_table(tmp_path / "t.parquet")
    assert len(table) == 801 + 601
    assert table["time"][801] == pytest.approx(13.0)
    assert np.max(np.abs(table["boom.spool"])) < 0.016


def test_the_same_seed_gives_the_same_log(logs, tmp_path, machine, bench):
    scenarios = [load_scenario("random:1:8"), load_scenario("random:2:6")]
    record(machine, scenarios, bench, tmp_path / "log.csv")
    assert (tmp_path / "log.csv").read_text() == (logs / "log.csv").read_text()
    record(machine, scenarios, Bench(bench.sensors, 4), tmp_path / "log.csv")
    assert (tmp_path / "log.csv").read_text() != (logs / "log.csv").read_text()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_recording_without_faults_is_healthy(tmp_path, machine, bench, seed):
    record(machine, [load_scenario(f"random:{seed}:15")], Bench(bench.sensors, seed), tmp_path / "log.csv")
    (tmp_path / "map.toml").write_text(suggest_channels(tmp_path / "log.csv"))
    found = import_log(tmp_path / "log.csv", load_channels(tmp_path / "map.toml"), tmp_path / "t.parquet")
    assert [str(f) for f in found.findings] == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('unit = "mm"', 'unit = "mn"'), "unit of sensor 'boom.spool': unknown unit|it is in m"),
        (('unit = "mm"', 'unit = "bar"'), "sensor 'boom.spool' = boom.spool in 'bar': it is in m"),
        (('"boom.spool"', '"boom.spol"'), "the run has no column 'boom.spol'"),
        (('raster = "20 ms"', 'raster = "20 mm"'), "raster of sensor 'boom.angle' = '20 mm': must be in s"),
        (('raster = "20 ms"', ""), "missing key 'raster' in sensor 3"),
        (('raster = "20 ms"', 'raster = "20 ms"\nnoize = 1'), "unknown key 'noize' in sensor 3"),
        (("noise = 0.3", "noise = -0.3"), "noise of sensor 'head' = -0.3: must lie in"),
        (("noise = 0.3", 'noise = "0.3"'), "noise of sensor 'head' = '0.3': must be a finite number"),
        (("noise = 0.3", "dropout = 1.0"), "dropout of sensor 'head' = 1.0: must lie in"),
        (("[-5, 400]", "[400, -5]"), "range of sensor 'head'"),
        (('name = "head"', 'name = "boom.spool"'), "each sensor needs its own"),
        (("seed = 3", "seed = -3"), "seed = -3: must be a whole number"),
        (("seed = 3", 'pause = "1 h"\nspeed = 3'), "unknown key 'speed'"),
    ],
)  # fmt: skip
def test_bad_sensors_are_one_error(tmp_path, machine, change, message):
    text = SENSORS.replace(*change)
    assert text != SENSORS
    (tmp_path / "sensors.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        record(machine, [load_scenario("random:1:1")], load_sensors(tmp_path / "sensors.toml"), tmp_path / "log.csv")
    assert not (tmp_path / "log.csv").exists()


def test_missing_things_are_one_error(tmp_path, machine, bench):
    with pytest.raises(InputError, match="no such file"):
        load_sensors(tmp_path / "sensors.toml")
    with pytest.raises(InputError, match="ends in one of"):
        record(machine, [load_scenario("random:1:1")], bench, tmp_path / "log.xls")
    with pytest.raises(InputError, match="no scenario to record"):
        record(machine, [], bench, tmp_path / "log.csv")
