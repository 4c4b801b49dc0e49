"""The virtual test bench: sensors do what they say, and logs of all formats hold the same."""

import numpy as np
import pytest

from polydraulic import load_scenario
from polydraulic.errors import InputError
from polydraulic.measure import import_log, load_channels, load_sensors, record, suggest_channels
from polydraulic.measure.bench.sensors import Bench
from polydraulic.tables import read_table

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
        (('"boom.spool"', '"boom.spol"'), "the run has no column 'boom.spol'; of boom it has .*boom.spool"),
        (
            ('"boom.spool"', '"arm.spool"'),
            "'arm.spool'; 'arm' is none of its functions and circuits; it has swing.spool, boom.spool, stick.spool",
        ),
        (('"boom.spool"', '"arm"'), "the run has no column 'arm'; it has time, "),
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


EXACT = """
[[sensor]]
column = "boom.angle"
unit = "rad"
raster = "10 ms"

[[sensor]]
column = "boom.p_a"
unit = "Pa"
raster = "10 ms"
noise = 1e4
"""


def test_faults_act_in_the_machine_and_in_what_sensors_read_before_noise(tmp_path, machine):
    (tmp_path / "sensors.toml").write_text(EXACT)
    bench, what = load_sensors(tmp_path / "sensors.toml"), [load_scenario("random:1:3"), load_scenario("random:2:3")]
    sensors = ["boom.p_a.bias 5 % from 2 s to 2.5 s", "boom.angle.freeze from 2.5 s to 10 s"]

    def log(name, faults):
        record(machine, what, bench, tmp_path / name, faults=faults)
        return read_table(tmp_path / name)

    healthy, deceived = log("healthy.parquet", ()), log("deceived.parquet", sensors)
    leaking = log("leaking.parquet", ["boom.leak_out 20 % from 9 s"])
    time, span = healthy["time"], machine.function("boom").line.relief
    off = (time > 2.0 - 1e-6) & (time < 2.5 - 1e-6)
    np.testing.assert_allclose(deceived["boom.p_a"] - healthy["boom.p_a"], np.where(off, 0.05 * span, 0.0), atol=1e-6)
    frozen = (time > 2.5 - 1e-6) & (time < 10.0 - 1e-6)  # from the first run into the second, which begins at 8 s
    np.testing.assert_array_equal(deceived["boom.angle"][~frozen], healthy["boom.angle"][~frozen])
    assert len(np.unique(deceived["boom.angle"][frozen])) == 1
    assert deceived["boom.angle"][frozen][0] == pytest.approx(healthy["boom.angle"][time < 2.5][-1], abs=1e-3)
    begun = time > 9.0 + 1e-6
    np.testing.assert_array_equal(leaking["boom.p_a"][~begun], healthy["boom.p_a"][~begun])
    assert np.max(np.abs(leaking["boom.p_a"] - healthy["boom.p_a"])[begun]) > 1e4


def test_a_fault_of_a_sensor_that_is_not_there_is_refused(tmp_path, machine, bench):
    with pytest.raises(
        InputError, match=r"a fault is of 'boom.p_b', which no sensor reads; there are sensors of boom.spool"
    ):
        record(machine, ["random:1:2"], bench, tmp_path / "log.csv", faults=["boom.p_b.bias"])
    with pytest.raises(InputError, match=r"'boom.pump_worn' begins at 60 s, and the log ends at 2 s"):
        record(machine, ["random:1:2"], bench, tmp_path / "log.csv", faults=["boom.pump_worn from 1 min"])
    assert not (tmp_path / "log.csv").exists()
