import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure.bench.sensors import Reading, Sensor, load_sensors
from polydraulic.tables import Table

RUN = Table({"time": np.arange(60_001) * 0.01, "p": np.full(60_001, 5e6)}, {"time": "s", "p": "Pa"})


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


@pytest.mark.parametrize("value", ["9" * 400, "1e308", "-1e308", "[[]]", "{}", "[1e308, inf]", "nan"])
@pytest.mark.parametrize(
    "key", ["noise", "offset", "drift", "resolution", "range", "delay", "lag", "dropout", "unit", "raster", "name"]
)
def test_strange_values_anywhere_in_a_sensor_are_one_error(key, value, tmp_path):
    entry = {"column": '"boom.p_a"', "unit": '"bar"', "raster": '"10 ms"'} | {key: value}
    path = tmp_path / "s.toml"
    path.write_text("[[sensor]]\n" + "\n".join(f"{name} = {text}" for name, text in entry.items()))
    with pytest.raises(InputError, match="s.toml"):
        load_sensors(path)


@pytest.mark.parametrize("name", ["a,b", "a\\nb", "a\\u0000b"])
def test_a_name_that_would_part_the_columns_of_a_text_log_is_refused(name, tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(f'[[sensor]]\ncolumn = "boom.p_a"\nunit = "bar"\nraster = "10 ms"\nname = "{name}"\n')
    with pytest.raises(InputError, match="name of sensor"):
        load_sensors(path)
