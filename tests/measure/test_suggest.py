import re
import tomllib

import pytest

from polydraulic.errors import InputError
from polydraulic.measure import load_channels, suggest_channels


def test_units_are_guessed_from_names_where_a_log_has_no_place_for_them(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(
        "time,boom_speed_deg_per_sec,force_lift_MN,engine_speed_rps,p_A,lever [V],x_mm [m]\n"
        + "".join(f"{k},{k},{k},{k},{k},{k},{k}\n" for k in range(5))
    )
    text = suggest_channels(log)
    found = dict(re.findall(r'source = "(.*?)"\nrole = "input"\nunit = "(.*?)"', text))
    assert found == {
        "boom_speed_deg_per_sec": "deg/s", "force_lift_MN": "MN", "engine_speed_rps": "rev/s", "p_A": "", "lever": "V", "x_mm": "m",
    }  # fmt: skip
    assert text.count("from its name: the log itself does not tell") == 3


@pytest.mark.parametrize(
    ("header", "first", "step", "unit"),
    [
        ("Zeitstempel", 1_711_850_398_000, 10, "ms"),
        ("timestamp", 1_711_850_398_000_000, 10_000, "us"),
        ("t", 1_711_850_398_000_000_000, 10_000_000, "ns"),
        ("Time", 1_711_850_398, 1, "s"),
        ("Elapsed Time (ms)", 0, 10, "ms"),
        ("time_us", 0, 10_000, "us"),
        ("time", 0, 1, "s"),
        ("tout", 0, 1, "s"),
        ("millis", 0, 10, "ms"),
        ("seconds", 0, 1, "s"),
        ("Sekunden", 0, 1, "s"),
        ("Date", 45_382.5, 0.01 / 86_400.0, "d"),  # as spreadsheets count days
        ("t", 739_342.5, 0.01 / 86_400.0, "d"),  # as MATLAB does
    ],
)
def test_the_time_and_its_unit_are_seen(tmp_path, header, first, step, unit):
    log = tmp_path / "log.csv"
    log.write_text(f"p,{header}\n" + "".join(f"{k % 7},{first + k * step}\n" for k in range(50)))
    text = suggest_channels(log)
    assert f'role = "time"\nunit = "{unit}"\n' in text
    assert f'raster = "{"1 s" if step == 1 else "10 ms"}"' in text


@pytest.mark.parametrize(("step", "unit"), [(7.7, "d"), (7.9, "s")])
def test_days_are_told_by_steps_that_no_log_has_in_seconds(tmp_path, step, unit):
    log = tmp_path / "log.csv"
    log.write_text("t,p\n" + "".join(f"{45_382.5 + k * step / 86_400.0},{k % 7}\n" for k in range(50)))
    assert f'role = "time"\nunit = "{unit}"\n' in suggest_channels(log)


@pytest.mark.parametrize(("least", "below", "unit"), [(1e11, "s", "ms"), (1e14, "ms", "us"), (1e17, "us", "ns")])
def test_the_unit_of_times_since_1970_goes_by_their_size(tmp_path, least, below, unit):
    """What is less than 1e11 would be 1973 in ms, what is more the year 5138 in s."""
    log = tmp_path / "log.csv"
    for first, expected in ((0.99 * least, below), (1.01 * least, unit)):
        log.write_text("t,p\n" + "".join(f"{first + k * 1e-6 * least:.0f},{k % 7}\n" for k in range(50)))
        assert f'role = "time"\nunit = "{expected}"\n' in suggest_channels(log)


@pytest.mark.parametrize(("still", "between"), [(6, "linear"), (7, "hold")])
def test_a_channel_is_held_where_more_than_six_of_ten_samples_are_like_the_one_before(tmp_path, still, between):
    log = tmp_path / "log.csv"
    value = [0] * (still + 1) + list(range(1, 11 - still))
    log.write_text("time,p\n" + "".join(f"{k},{p}\n" for k, p in enumerate(value)))
    assert f'between = "{between}"' in suggest_channels(log)


@pytest.mark.parametrize(("low", "ends"), [(-4.9, "-60, 160"), (-5.1, "-160, 160")])
def test_the_other_sign_counts_from_a_twentieth_on(tmp_path, low, ends):
    log = tmp_path / "log.csv"
    log.write_text("time,p\n" + "".join(f"{k},{low if k == 7 else 2.0 * k}\n" for k in range(51)))
    assert f"range = [{ends}]" in suggest_channels(log)


@pytest.mark.parametrize(("high", "ends"), [(20, "-10, 30"), (38, "-20, 58"), (90, "-45, 135"), (101, "-60, 160")])
def test_ends_of_ranges_are_whole_ones_twos_or_fives(tmp_path, high, ends):
    log = tmp_path / "log.csv"
    log.write_text("time,p\n" + "".join(f"{k},{high * (k % 2)}\n" for k in range(9)))
    assert f"range = [{ends}]" in suggest_channels(log)


def test_one_row_is_one_error(tmp_path):
    (tmp_path / "log.csv").write_text("time,p\n45382.5,1\n")
    with pytest.raises(InputError, match="no channel holds numbers that vary"):
        suggest_channels(tmp_path / "log.csv")


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_dates_in_doubt_are_asked_for(tmp_path, ending):
    import pyarrow as pa
    import pyarrow.csv
    import pyarrow.parquet

    table = pa.table({"time": [f"03/04/2024 10:00:{k:02d}" for k in range(50)], "p": [float(k % 7) for k in range(50)]})
    (pa.csv.write_csv if ending == "csv" else pa.parquet.write_table)(table, tmp_path / f"log.{ending}")
    text = suggest_channels(tmp_path / f"log.{ending}")
    assert '# "03/04/2024 10:00:00" can be read in two ways; say which:\n# dates = "dd/mm/yyyy"\n' in text
    assert 'raster = "1 s"' in text


def test_channels_of_one_unit_have_one_range_and_angles_none(tmp_path):
    log = tmp_path / "log.csv"
    columns = {
        "time [s]": (0, 2), "p_a [bar]": (0, 200), "p_b [bar]": (20, 318), "left [%]": (-100, 20), "right [%]": (0, 90),
        "slew.angle [deg]": (-150, 80), "turned [rad]": (0, 3), "depth [mm]": (5, 5), "reach [mm]": (100, 300), "a": (1, 3), "b": (10, 30),
    }  # fmt: skip
    rows = (",".join(str(low + (high - low) * k / 8) for low, high in columns.values()) for k in range(9))
    log.write_text("\n".join([",".join(columns), *rows]) + "\n")
    found = {c["source"]: c.get("range") for c in tomllib.loads(suggest_channels(log))["channel"]}
    assert found == {
        "time": None, "p_a": [-1, 480], "p_b": [-1, 480], "left": [-200, 200], "right": [-200, 200],
        "slew.angle": None, "turned": None, "depth": None, "reach": [0, 400], "a": [0, 4], "b": [0, 40],
    }  # fmt: skip


def test_numbers_that_stand_for_no_value_widen_no_range(tmp_path):
    log = tmp_path / "log.csv"
    largest = [1.7976931348623157e308 if k % 9 == 0 else 100.0 + k for k in range(50)]
    log.write_text("time [s],pa [bar],pb [bar]\n" + "".join(f"{k},{v!r},{k}\n" for k, v in enumerate(largest)))
    ranges = re.findall(r"range = (.*)", suggest_channels(log))
    assert ranges == ["[-1, 230]"] * 2


@pytest.mark.parametrize(
    ("head", "first", "least"),
    [
        ("p [bar]", 0.0, -1), ("p [bar]", -0.9, -1), ("p [kPa]", 0.0, -100), ("p [psi]", 0.0, -15), ("p [MPa]", 0.05, -0.1), ("p [bar(a)]", 1.0, 0),
        ("p [bar]", -3.0, -300), ("dp [bar]", 0.0, -250), ("Δp [bar]", 0.0, -250), ("p_diff [bar]", 0.0, -250), ("x [mm]", 0.0, -250),
    ],
)  # fmt: skip
def test_no_pressure_is_suggested_below_a_vacuum_but_differences_and_what_was_seen(tmp_path, head, first, least):
    log = tmp_path / "log.csv"
    log.write_text(f"time [s],{head}\n" + "".join(f"{k},{first + 10 * k}\n" for k in range(51)))
    assert tomllib.loads(suggest_channels(log))["channel"][1]["range"][0] == least


def test_flows_are_suggested_as_outputs_and_all_else_as_inputs(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time [s],q [l/min],p [bar],x\n" + "".join(f"{k},{k % 7},{k % 5},{k % 3}\n" for k in range(51)))
    text = suggest_channels(log)
    assert [c["role"] for c in tomllib.loads(text)["channel"]] == ["time", "output", "input", "input"]
    assert "flows are outputs here and all else is an input, so choose" in text.replace("\n#   ", " ")


def test_a_little_below_zero_is_no_other_sign(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(
        "time [s],p [bar],u [V]\n" + "".join(f"{k},{-0.3 if k == 7 else 5.0 * k},{k % 9 - 4}\n" for k in range(51))
    )
    assert re.findall(r"range = (.*)", suggest_channels(log)) == ["[-1, 380]", "[-8, 8]"]


def test_a_column_that_counts_the_rows_is_no_input(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(",time,p,index\n" + "".join(f"{k + 7},{k},{k % 5},{k % 9}\n" for k in range(50)))
    assert re.findall(r'source = "(.*)"\nrole = "(?:input|time)"', suggest_channels(log)) == ["time", "p", "index"]


@pytest.mark.parametrize(("first", "step"), [(0.0, 1e-300), (1e9, 1e-4), (2.0**60, 512.0)])
def test_a_suggested_range_is_one_whatever_the_numbers(tmp_path, first, step):
    log = tmp_path / "log.csv"
    log.write_text("time,p\n" + "".join(f"{k * 1e-8},{first + k % 7 * step}\n" for k in range(50)))
    (tmp_path / "map.toml").write_text(suggest_channels(log))
    channel = load_channels(tmp_path / "map.toml").used[0]
    assert channel.low <= first < first + 6 * step <= channel.high


@pytest.mark.parametrize(("header", "unit"), [("X_Value,p", "s"), ("x-axis (ms),p", "ms"), ("run [s],p", "s")])
def test_the_first_column_may_be_the_time_by_its_unit(tmp_path, header, unit):
    log = tmp_path / "log.csv"
    log.write_text(f"{header}\n" + "".join(f"{k},{k % 7}\n" for k in range(50)))
    assert f'role = "time"\nunit = "{unit}"\n' in suggest_channels(log)
    log.write_text(f"time,{header}\n" + "".join(f"{k},{k},{k % 7}\n" for k in range(50)))
    assert 'source = "time"\nrole = "time"' in suggest_channels(log)


@pytest.mark.parametrize(
    ("header", "step", "time"),
    [
        ("Time since start,p", 0.01, True),
        ("", 0.01, True),
        ("x,p", 1.0, False),  # it counts the rows
        ("sample,p", 2.0, False),
    ],
)
def test_a_first_column_that_rises_evenly_is_the_time_and_the_map_says_that_its_unit_is_a_guess(
    tmp_path, header, step, time
):
    log = tmp_path / "log.csv"
    log.write_text(f"{header}\n" * bool(header) + "".join(f"{step * k:.2f},{1.5 + k % 7}\n" for k in range(50)))
    text = suggest_channels(log)
    assert ('role = "time"' in text) == time
    assert ("taken as the time, as it rises evenly; the log does not tell the unit" in text) == time
    assert ('interval = "10 ms"' in text) != time


def test_the_unit_of_a_time_that_says_none_is_a_guess_and_said_to_be_one(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time,p\n" + "".join(f"{10 * k},{k % 7}\n" for k in range(50)))
    assert 'unit = "s"\n# the log does not tell the unit: look whether rasters come out right' in suggest_channels(log)
    log.write_text("time [s],p\n" + "".join(f"{10 * k},{k % 7}\n" for k in range(50)))
    assert "does not tell the unit" not in suggest_channels(log)
