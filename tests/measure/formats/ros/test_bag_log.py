"""Bags of every format against a second reader, and what is said of messages that are not read."""

import shutil
import sqlite3
import sys

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as OtherWriter

from helpers.bag_made import BEGAN, HEAD, TIME, Messages, whole_ns, work, write_bag
from polydraulic.errors import InputError
from polydraulic.measure import import_log, open_log, suggest_channels
from polydraulic.measure.channels import channel_map
from polydraulic.measure.findings import Findings
from polydraulic.tables import read_table

MAKE = Messages()
USED = [
    {"source": "/joint_states/boom.position", "name": "boom.angle", "role": "input", "unit": "rad"},
    {"source": "/pump/fluid_pressure", "name": "pump.p", "role": "input", "unit": "Pa(a)"},
    {"source": "/spool/data", "name": "spool", "role": "output", "unit": "mm"},
]


def columns(path):
    """Time and values of every signal of a bag, and what was found."""
    found, findings = {}, Findings()
    with open_log(path) as log:
        for signal in log.signals:
            blocks = list(log.read(signal.group, [signal.name], None, findings))
            time = np.concatenate([block.time for block in blocks]) + log.began
            found[signal.name] = time, np.concatenate([block.values[signal.name] for block in blocks])
        return found, {s.name: s for s in log.signals}, log.left_out, findings


def second(path):
    """The same as another reader sees it: mcap with its own decoder of ROS 2."""
    found = {}

    def put(name, receipt, of, value):
        at = of.header.stamp.sec + 1e-9 * of.header.stamp.nanosec if hasattr(of, "header") else receipt
        found.setdefault(name, []).append((at, value))

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, of in reader.iter_decoded_messages():
            receipt = 1e-9 * message.log_time
            if channel.topic == "/joint_states":
                for field in ("position", "velocity", "effort"):
                    for joint, value in zip(of.name, getattr(of, field), strict=False):
                        put(f"/joint_states/{joint}.{field}", receipt, of, value)
            else:
                for field in ("fluid_pressure", "variance") if channel.topic == "/pump" else ("data",):
                    put(f"{channel.topic}/{field}", receipt, of, getattr(of, field))
    return {name: np.array(rows).T for name, rows in found.items()}


@pytest.mark.parametrize("storage", ["mcap", "db3", "bag"])
def test_every_number_is_what_a_second_reader_reads(tmp_path, storage):
    write_bag(tmp_path / "reference", work(MAKE))
    make = Messages(old=storage == "bag")
    path = write_bag(tmp_path / ("log.bag" if storage == "bag" else "log"), work(make), storage, make)
    expected = second(tmp_path / "reference" / "reference.mcap")
    assert len(expected) == 7
    for place in [path] if storage == "bag" else [path, path / f"log.{storage}"]:
        found, _, left_out, _ = columns(place)
        assert set(found) == set(expected)
        assert left_out == {}
        for name, (time, values) in expected.items():
            assert found[name][0] == pytest.approx(time, abs=1e-6), name
            assert np.array_equal(found[name][1], values), name


@pytest.mark.parametrize(
    ("storage", "compressed"), [("mcap", "STORAGE"), ("mcap", "FILE"), ("db3", "FILE"), ("db3", "MESSAGE")]
)
def test_compressed_bags_hold_the_same(tmp_path, storage, compressed):
    plain = columns(write_bag(tmp_path / "plain", work(MAKE)))[0]
    found, _, left_out, _ = columns(write_bag(tmp_path / "small", work(MAKE), storage, compressed=compressed))
    assert left_out == {}
    assert found.keys() == plain.keys()
    for name, (time, values) in plain.items():
        assert np.array_equal(found[name], (time, values)), name


@pytest.mark.parametrize("kind", ["sensor_msgs/msg/FluidPressure", "sensor_msgs/FluidPressure"])
def test_files_of_another_writer_are_read(tmp_path, kind):
    definition, _ = MAKE.store.generate_msgdef("sensor_msgs/msg/FluidPressure", ros_version=2)
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = OtherWriter(file)
        schema = writer.register_msgdef(kind, definition)
        for k, t in enumerate(TIME):
            ns = whole_ns(BEGAN + t)
            stamp = {"sec": ns // 10**9, "nanosec": ns % 10**9}
            message = {"header": {"stamp": stamp, "frame_id": ""}, "fluid_pressure": HEAD[k], "variance": 0.0}
            writer.write_message(topic="/pump", schema=schema, message=message, log_time=ns, publish_time=ns)
        writer.finish()
    found, signals, left_out, _ = columns(tmp_path / "a.mcap")
    assert np.array_equal(found["/pump/fluid_pressure"][1], HEAD)
    assert (signals["/pump/fluid_pressure"].unit, left_out) == ("Pa(a)", {})


def test_units_are_those_of_the_definitions(tmp_path):
    _, signals, _, _ = columns(write_bag(tmp_path / "log", work(MAKE)))
    units = {name: (signal.unit, signal.other_unit) for name, signal in signals.items()}
    assert units["/joint_states/boom.position"] == ("rad", "m")
    assert units["/pump/fluid_pressure"] == ("Pa(a)", "Pa")
    assert units["/joint_states/boom.effort"] == units["/spool/data"] == ("", "")


def test_topics_with_clocks_of_their_own_make_one_table(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE))
    found = import_log(
        path, channel_map({"raster": "10 ms", "atmosphere": "1 bar", "channel": USED}), tmp_path / "t.csv"
    )
    table = read_table(tmp_path / "t.csv")
    assert found.began == BEGAN
    assert {f.kind for f in found.findings} == set()
    assert table["time"] == pytest.approx(TIME)
    assert table["boom.angle"] == pytest.approx(0.1 * np.sin(9.0 * TIME))
    assert table["pump.p"] == pytest.approx(HEAD - 1e5)
    assert table["spool"] == pytest.approx(0.0005 * TIME)


def test_a_map_may_take_the_other_unit_of_a_definition(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE))
    for unit, kinds in (("Pa", set()), ("bar", {"unit"})):
        channels = [dict(USED[1], unit=unit), dict(USED[0], unit="m", role="output")]
        found = import_log(path, channel_map({"raster": "10 ms", "channel": channels}), tmp_path / "t.csv")
        assert {f.kind for f in found.findings} == kinds


def test_a_first_map_is_written_and_can_be_used(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE))
    text = suggest_channels(path)
    assert 'source = "/joint_states/boom.position"\nrole = "input"\nunit = "rad"  # or m\n' in text
    assert 'source = "/pump/fluid_pressure"\nrole = "input"\nunit = "Pa(a)"  # or Pa\n' in text
    assert 'source = "/pump/variance"\nrole = "ignore"  # it is constant\n' in text


def test_names_may_be_shortened_where_no_other_topic_has_them(tmp_path):
    messages = [*work(MAKE), *(("/tank", "std_msgs/msg/Float64", BEGAN, MAKE.number(k)) for k in range(3))]
    with open_log(write_bag(tmp_path / "log", messages)) as log:
        names = {"boom.position", "joint_states/boom.position", "/joint_states/boom.position"}
        assert {log.signal(name).name for name in names} == {"/joint_states/boom.position"}
        assert log.signal("tank/data").name == "/tank/data"
        with pytest.raises(InputError, match="no channel 'data'"):
            log.signal("data")


def test_headers_that_are_late_early_or_empty_are_named(tmp_path):
    for late, stamps, said in (
        (0.002, lambda t: BEGAN + t, None),
        (0.099, lambda t: BEGAN + t, None),
        (0.101, lambda t: BEGAN + t, ("stamps", "received 0.101 to 0.101 s after their stamps")),
        (2.5, lambda t: BEGAN + t, ("stamps", "received 2.5 to 2.5 s after their stamps")),
        (0.0, lambda t: BEGAN + t + 3.0 * t, ("stamps", "received -1.77 to 0 s after their stamps")),
        (0.25, lambda t: None, ("unstamped", "")),
    ):
        path = write_bag(tmp_path / f"log{late}", work(MAKE, late, stamps))
        found, _, _, findings = columns(path)
        named = {(f.kind, f.detail) for f in findings if f.channel == "/pump"}
        assert named == ({said} if said else set())
        times = found["/pump/fluid_pressure"][0]
        expected = [BEGAN + t + late if stamps(t) is None else stamps(t) for t in TIME]
        assert times == pytest.approx(expected, abs=1e-6)


def test_a_single_header_without_a_time_is_a_row_without_a_time(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE, stamps=lambda t: None if t == 0.05 else BEGAN + t))
    found = import_log(path, channel_map({"raster": "10 ms", "channel": USED[:2]}), tmp_path / "t.csv")
    assert {(f.kind, f.channel, tuple(f.rows)) for f in found.findings if f.kind == "no time"} == {
        ("no time", "group 0", ((6, 6),)),
        ("no time", "group 1", ((6, 6),)),
    }


@pytest.mark.parametrize(("begin", "began"), [(315_532_799, 0.0), (315_532_801, 315_532_801.0)])
def test_clocks_of_bags_show_dates_from_1980_on(tmp_path, begin, began):
    messages = work(MAKE, stamps=lambda t: begin + t)
    path = write_bag(tmp_path / "log", ((topic, kind, at - BEGAN + begin, m) for topic, kind, at, m in messages))
    with open_log(path) as log:
        assert log.began == began
    assert columns(path)[0]["/pump/fluid_pressure"][0] == pytest.approx(begin + TIME, abs=1e-6)


def test_stamps_of_a_simulation_are_times_of_their_own(tmp_path):
    found, _, _, findings = columns(write_bag(tmp_path / "log", work(MAKE, stamps=lambda t: t + 5.0)))
    assert found["/pump/fluid_pressure"][0] == pytest.approx(TIME + 5.0, abs=1e-6)
    assert "s after their stamps" in findings.of("stamps", "/pump")[0].detail


def valve(k, pressures=(1.0, 2.0)):
    numbers = k % 2 == 0, 3 * k, np.array([7.0, 8.0, 9.0], dtype=np.float32), np.array(pressures, dtype=np.float64)
    lands = MAKE.of("rig_msgs/msg/Lands", ["a", ""], np.array([0.5, 0.25]))
    message = MAKE.of("rig_msgs/msg/Valve", MAKE.header(BEGAN + 0.01 * k), "main", *numbers, lands)
    return "/valve", "rig_msgs/msg/Valve", BEGAN + 0.01 * k, message


def test_messages_of_ones_own_are_flattened(tmp_path):
    found, _, left_out, _ = columns(write_bag(tmp_path / "log", [valve(k, [k] * (1 + k % 2)) for k in range(4)]))
    assert {name: values.tolist() for name, (_, values) in found.items() if name != "/valve/pressures[1]"} == {
        "/valve/open": [1, 0, 1, 0],
        "/valve/serial": [0, 3, 6, 9],
        "/valve/current[0]": [7] * 4,
        "/valve/current[1]": [8] * 4,
        "/valve/current[2]": [9] * 4,
        "/valve/pressures[0]": [0, 1, 2, 3],
        "/valve/lands.a.wear": [0.5] * 4,
        "/valve/lands.element[1].wear": [0.25] * 4,
    }
    assert found["/valve/pressures[1]"][1] == pytest.approx([np.nan, 1, np.nan, 3], nan_ok=True)
    assert left_out == {}


def test_whole_numbers_beyond_double_precision_are_missing(tmp_path):
    make = Messages()
    numbers = [1, 2**53 + 1, -(2**62), 2**53 - 1]
    messages = [
        ("/n", "std_msgs/msg/Int64", BEGAN + k, make.of("std_msgs/msg/Int64", n)) for k, n in enumerate(numbers)
    ]
    with open_log(write_bag(tmp_path / "log", messages)) as log:
        (block,) = log.read(0, ["/n/data"], None, Findings())
    assert block.values["/n/data"] == pytest.approx([1, np.nan, np.nan, 2**53 - 1], nan_ok=True)
    assert block.text["/n/data"].tolist() == [1, 2]


def test_joints_of_several_publishers_of_a_topic_have_clocks_of_their_own(tmp_path):
    messages = []
    for k in range(30):
        for shift, name in ((0.0, "boom"), (0.004, "gripper")):
            at = BEGAN + 0.01 * k + shift
            messages.append(("/joint_states", "sensor_msgs/msg/JointState", at, MAKE.joints(at, [name], [k])))
    found, signals, _, _ = columns(write_bag(tmp_path / "log", messages))
    assert [signals[f"/joint_states/{n}.position"].group for n in ("boom", "gripper")] == [0, 1]
    for n, shift in (("boom", 0.0), ("gripper", 0.004)):
        time, values = found[f"/joint_states/{n}.position"]
        assert values.tolist() == list(range(30))
        assert time == pytest.approx(BEGAN + 0.01 * np.arange(30) + shift, abs=1e-6)


def test_what_is_not_read_is_named(tmp_path):
    make, times = MAKE, [BEGAN + k for k in range(5)]
    messages = list(work(make))
    messages += [("/said", "std_msgs/msg/String", t, make.of("std_msgs/msg/String", "on")) for t in times]
    messages += [("/silent", "std_msgs/msg/Float64", BEGAN, None)]
    tf = make.of("tf2_msgs/msg/TFMessage", [])
    messages += [("/tf", "tf2_msgs/msg/TFMessage", t, tf) for t in times]
    layout = make.of("std_msgs/msg/MultiArrayLayout", [], 0)
    long = make.of("std_msgs/msg/Float64MultiArray", layout, np.zeros(100))
    messages += [("/long", "std_msgs/msg/Float64MultiArray", t, long) for t in times]
    uneven = [make.joints(t, ["a", "b"], [1.0, 2.0], velocity=[1.0]) for t in times]
    messages += [("/uneven", "sensor_msgs/msg/JointState", t, m) for t, m in zip(times, uneven, strict=True)]
    found, _, left_out, _ = columns(write_bag(tmp_path / "log", messages))
    assert left_out == {
        "/said": "std_msgs/msg/String holds no numbers",
        "/silent": "no message",
        "/tf": "tf2_msgs/msg/TFMessage holds a list of messages (transforms)",
        "/long/data": "an array of more than 64 numbers",
        "/uneven/velocity: 5 of 5 messages": "not one value for each name",
    }
    assert "/uneven/a.position" in found


def test_damaged_messages_are_counted(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE), "db3")
    with sqlite3.connect(path / "log.db3") as database:
        database.execute("UPDATE messages SET data = substr(data, 1, 9) WHERE id IN (2, 5)")
    database.close()
    _, _, left_out, _ = columns(path)
    assert left_out == {"/pump: 2 of 60 messages": "damaged, or not of the type that the bag says"}


def test_old_databases_without_definitions_are_read_where_ros_itself_has_the_type(tmp_path):
    path = write_bag(tmp_path / "log", [*work(MAKE), *(valve(k) for k in range(3))], "db3")
    with sqlite3.connect(path / "log.db3") as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    found, _, left_out, _ = columns(path)
    assert found["/pump/fluid_pressure"][1] == pytest.approx(HEAD)
    assert left_out == {"/valve": "its type rig_msgs/msg/Valve is not defined in the bag, and is not one of ROS itself"}


def test_what_a_recorder_did_not_finish_is_named(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE), "db3")
    (path / "log.db3-wal").write_bytes(b"\0" * 100)
    assert list(columns(path)[2]) == ["log.db3-wal"]


def test_bags_that_cannot_be_read_are_refused_with_what_helps(tmp_path):
    path = write_bag(tmp_path / "log", work(MAKE))
    content = (path / "log.mcap").read_bytes()
    for name, wrong, told in (
        ("cut.mcap", content[:-2000], "is cut off.*mcap recover"),
        ("empty.mcap", b"", "cannot be read as a ROS bag"),
        ("text.db3", b"no database at all" * 99, "cannot be read as a ROS bag"),
        ("text.bag", b"no bag at all" * 99, "cannot be read as a ROS bag"),
        ("a#b.mcap", content, "may hold no '\\?', '#' or '%'"),
    ):
        (tmp_path / name).write_bytes(wrong)
        with pytest.raises(InputError, match=told):
            open_log(tmp_path / name)
    (path / "metadata.yaml").unlink()
    with pytest.raises(InputError, match="without metadata.yaml is not a bag.*give its files: log.mcap"):
        open_log(path)
    messages = [("/said", "std_msgs/msg/String", BEGAN, MAKE.of("std_msgs/msg/String", "on"))]
    with pytest.raises(
        InputError, match="no topic whose messages hold numbers: /said: std_msgs/msg/String holds no numbers"
    ):
        open_log(write_bag(tmp_path / "texts", messages))


def test_bags_of_one_campaign_are_joined(tmp_path):
    def later(messages, by):
        for topic, kind, at, message in messages:
            yield topic, kind, at + by, message

    one = write_bag(tmp_path / "one", work(MAKE))
    two = write_bag(tmp_path / "two", later(work(MAKE, stamps=lambda t: BEGAN + t + 10.0), 10.0), "db3")
    shutil.copytree(one, tmp_path / "copy")
    given = channel_map({"raster": "10 ms", "channel": USED})
    found = import_log([two, one, tmp_path / "copy"], given, tmp_path / "t.csv")
    assert found.findings.of("file repeats")[0].detail == "copy is one"
    assert read_table(tmp_path / "t.csv")["time"] == pytest.approx(np.concatenate([TIME, TIME + 10.0]))


def test_without_rosbags_the_extra_is_named(tmp_path, monkeypatch):
    path = write_bag(tmp_path / "log", work(MAKE))
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(InputError, match="rosbags is not installed.*polydraulic\\[ros\\]"):
        open_log(path)
