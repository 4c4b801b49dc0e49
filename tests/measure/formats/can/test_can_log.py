"""Bus logs of every format against a decoding of their own, bit by bit, and against asammdf's."""

import numpy as np
import pytest

from helpers.can_made import DBC, ENGINE, bus, write_bus
from polydraulic.errors import InputError
from polydraulic.measure import import_log, open_log, suggest_channels
from polydraulic.measure.channels import channel_map
from polydraulic.measure.findings import Findings

ENDINGS = ["mf4", "blf", "asc"]


def whole(data, start, length, big, signed):
    """One number out of one frame, by shifting the frame as a whole; None where it is too short."""
    n = 8 * len(data)
    if big:
        first = 8 * (start // 8) + 7 - start % 8  # from the left
        if first + length > n:
            return None
        number = int.from_bytes(data, "big") >> (n - first - length)
    else:
        if start + length > n:
            return None
        number = int.from_bytes(data, "little") >> start
    number &= 2**length - 1
    return number - 2**length if signed and number >= 2 ** (length - 1) else number


def expected():
    """Times and values by signal."""
    found = {name: [] for name in "spool p_head mode temp late speed torque brake gear page a inner b".split()}

    def add(name, time, raw, scale=1.0, offset=0.0, none=()):
        found[name].append((time, np.nan if raw is None or raw in none else scale * raw + offset))

    for time, frame, _, data in bus():
        if frame == 256:
            add("spool", time, whole(data, 12, 13, False, True), 0.01)
            add("p_head", time, whole(data, 28, 11, True, True), 0.5, 10.0)
            add("mode", time, whole(data, 36, 2, False, False), none=(3,))
            add("temp", time, whole(data, 40, 8, False, False), 0.4, -40.0, none=(254, 255))
            add("late", time, whole(data, 56, 8, False, False))
        elif frame == ENGINE:
            add("speed", time, whole(data, 24, 16, False, False), 0.125, none=range(0xFE00, 0x10000))
            add("torque", time, whole(data, 8, 8, False, False), 1.0, -125.0, none=(254, 255))
            add("brake", time, whole(data, 0, 2, False, False), none=(2, 3))
            add("gear", time, whole(data, 4, 4, False, False), none=(14, 15))
        elif frame == 512:
            page, inner = data[0] & 15, data[0] >> 4
            add("page", time, page)
            if page == 0:
                add("a", time, whole(data, 8, 16, False, True), 0.1)
            if page == 1:
                add("inner", time, inner)
                if inner in (2, 3, 5):
                    add("b", time, whole(data, 15, 16, True, False))
    return {name: np.array(rows).T for name, rows in found.items()}


@pytest.fixture(scope="module", params=ENDINGS)
def log(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("can")
    (folder / "bus.dbc").write_text(DBC)
    return write_bus(folder / f"bus.{request.param}", bus()), folder / "bus.dbc"


def test_every_signal_is_what_its_bits_say(log):
    path, dbc = log
    findings = Findings()
    with open_log(path, dbc=[dbc]) as found:
        signals = {s.name: s for s in found.signals}
        assert found.left_out == {"0x7ff": "frames that no database knows"}
        for name, (time, values) in expected().items():
            (block,) = found.read(signals[name].group, [name], None, findings)
            assert block.values[name] == pytest.approx(values, nan_ok=True, abs=1e-9), name
            assert np.diff(block.time) == pytest.approx(np.diff(time), abs=2e-6), name
            assert np.isnan(values).any() or name in ("spool", "p_head", "page", "a", "inner", "b")
    assert [signals[n].unit for n in ("spool", "p_head", "speed", "mode")] == ["mm", "bar", "rpm", ""]
    assert "'error', 'not available'" in str(findings.of("status", "torque") + findings.of("status", "brake"))
    assert "'not available'" in str(findings.of("status", "speed")[0])
    assert "'error'" in str(findings.of("status", "speed")[0])
    assert "'sensor broken'" in str(findings.of("status", "temp")[0])
    assert findings.of("short frame", "late")[0].count == 8
    assert [f.channel for f in findings.of("short frame")] == ["late"]


def test_a_bus_log_without_databases_is_said_to_be_one(log):
    with pytest.raises(InputError, match=r"raw bus log \(frames with identifiers and data bytes.*--dbc"):
        open_log(log[0])


def test_a_table_comes_of_a_bus_log(log, tmp_path):
    path, dbc = log
    channels = [
        {"source": "speed", "role": "input", "unit": "rpm"},
        {"source": "Valve/spool", "name": "x", "role": "input", "unit": "mm"},
    ]
    found = import_log(path, channel_map({"raster": "10 ms", "channel": channels}), tmp_path / "t.parquet", dbc=[dbc])
    assert found.n_row > 200
    assert found.findings.of("status", "speed")
    text = suggest_channels(path, dbc=[dbc])
    assert 'source = "p_head"\nrole = "input"\nunit = "bar"' in text
    assert "0x7ff" in text


def test_the_same_as_asammdf_where_both_decode(tmp_path):
    from asammdf import MDF

    both = [("Valve", "spool"), ("Valve", "p_head"), ("Engine", "speed"), ("Engine", "torque"), ("Engine", "gear"),
            ("Multi", "page"), ("Multi", "a"), ("Multi", "inner"), ("Multi", "b")]  # fmt: skip
    (tmp_path / "bus.dbc").write_text(DBC)
    path = write_bus(tmp_path / "bus.mf4", bus())
    with MDF(path) as file:
        other = file.extract_bus_logging({"CAN": [(str(tmp_path / "bus.dbc"), 0)]}, ignore_value2text_conversion=True)
        theirs = {name: other.get(f"{message}.{name}") for message, name in both}
    with open_log(path, dbc=[tmp_path / "bus.dbc"]) as log:
        for _, name in both:
            (block,) = log.read(log.signal(name).group, [name], None, Findings())
            there = np.isfinite(block.values[name])
            found = dict(zip(block.time[there].tolist(), block.values[name][there].tolist(), strict=True))
            same = [t in found for t in theirs[name].timestamps.tolist()]
            assert all(same)
            assert theirs[name].samples == pytest.approx([found[t] for t in theirs[name].timestamps.tolist()], abs=1e-9)


def test_senders_of_one_j1939_message_are_kept_apart(tmp_path):
    (tmp_path / "bus.dbc").write_text(DBC)
    two = [
        (0.01 * k, 0x18FEF100 + sender, True, bytes([0, 100 + sender] + [0] * 6))
        for k in range(20)
        for sender in (1, 2)
    ]
    path = write_bus(tmp_path / "a.blf", two)
    with open_log(path, dbc=[tmp_path / "bus.dbc"]) as log:
        for name, value in (("Engine@0x01/torque", -24.0), ("Engine@0x02/torque", -23.0)):
            (block,) = log.read(log.signal(name).group, [name], None, Findings())
            assert set(block.values[name]) == {value}
        assert "torque" in log.duplicates


FRAME_FORMAT = 'BA_ "VFrameFormat" BO_ 2566844672 {};'


@pytest.mark.parametrize(
    ("attributes", "j1939"),
    [
        (FRAME_FORMAT.format(3), True),
        (FRAME_FORMAT.format(1), False),
        ('BA_DEF_ "ProtocolType" STRING ;\nBA_DEF_DEF_ "ProtocolType" "";\nBA_ "ProtocolType" "J1939";', True),
        ("", False),
    ],
)
def test_messages_are_of_j1939_where_the_database_says_so(tmp_path, attributes, j1939):
    (tmp_path / "bus.dbc").write_text(DBC.replace(FRAME_FORMAT.format(3), attributes))
    frame = 2566844672 & 0x1FFFFFFF
    path = write_bus(tmp_path / "a.blf", [(0.01 * k, frame, True, bytes([0, 250 + k] + [0] * 6)) for k in range(6)])
    findings = Findings()
    with open_log(path, dbc=[tmp_path / "bus.dbc"]) as log:
        (block,) = log.read(log.signal("torque").group, ["torque"], None, findings)
    assert np.isnan(block.values["torque"]).tolist() == [False] + [j1939] * 5
    said = [
        text
        for f in findings.of("status")
        for text in ("specific", "reserved", "error", "not available")
        if text in f.detail
    ]
    assert said == (["specific", "reserved", "error", "not available"] if j1939 else [])


def test_a_value_that_a_database_names_is_none_of_these_codes(tmp_path):
    named = "VAL_ 2566844672 torque " + " ".join(f'{k} "mode {k}"' for k in range(253)) + " ;\n"
    states = DBC.replace('(1,-125) [-125|125] "%"', '(1,0) [0|0] ""') + named
    (tmp_path / "bus.dbc").write_text(states)
    frame = 2566844672 & 0x1FFFFFFF
    path = write_bus(tmp_path / "a.blf", [(0.01 * k, frame, True, bytes([0, 250 + k] + [0] * 6)) for k in range(6)])
    with open_log(path, dbc=[tmp_path / "bus.dbc"]) as log:
        (block,) = log.read(log.signal("torque").group, ["torque"], None, Findings())
    assert block.values["torque"] == pytest.approx([250, 251, 252, np.nan, np.nan, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("dbc", "message"),
    [
        ("nonsense", "cannot be read as a CAN database"),
        (DBC.replace("BO_ 256 ", "BO_ 300 ").replace("VAL_ 256", "VAL_ 300").replace("2566844672", "2566844673")
         .replace("BO_ 512", "BO_ 513").replace("MUL_VAL_ 512", "MUL_VAL_ 513").replace("18FEF1", "18FEF2"), None),
    ],
)  # fmt: skip
def test_databases_that_do_not_fit_are_one_error(tmp_path, dbc, message):
    (tmp_path / "a.dbc").write_text(dbc)
    path = write_bus(tmp_path / "a.blf", [f for f in bus(5) if not f[2]])
    with pytest.raises(InputError, match=message or "no frame that a.dbc knows; identifiers of the log: 0x100, 0x200"):
        open_log(path, dbc=[tmp_path / "a.dbc"])


def test_databases_that_contradict_each_other_are_refused(tmp_path):
    (tmp_path / "a.dbc").write_text(DBC)
    (tmp_path / "b.dbc").write_text(DBC.replace("(0.01,0)", "(0.02,0)"))
    path = write_bus(tmp_path / "a.blf", bus(5))
    with pytest.raises(InputError, match=r"b.dbc: message 'Valve' has the identifier 0x100 of 'Valve' in .*a.dbc"):
        open_log(path, dbc=[tmp_path / "a.dbc", tmp_path / "b.dbc"])
    with pytest.raises(InputError, match="CAN databases go with a bus log"):
        (tmp_path / "a.csv").write_text("t,a\n1,2\n")
        open_log(tmp_path / "a.csv", dbc=[tmp_path / "a.dbc"])


def test_a_blf_log_that_is_cut_off_is_named(tmp_path):
    (tmp_path / "a.dbc").write_text(DBC)
    path = write_bus(tmp_path / "a.blf", bus(60))
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[: size // 2])
    with open_log(path, dbc=[tmp_path / "a.dbc"]) as log:
        (block,) = log.read(log.signal("spool").group, ["spool"], None, Findings())
        assert 10 < len(block.time) < 50
        assert log.left_out["the end of the log"] == f"the file is cut off after {size // 2} of {size} bytes"


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_damaged_bus_log_is_one_error(tmp_path, ending):
    (tmp_path / "a.dbc").write_text(DBC)
    (tmp_path / f"a.{ending}").write_bytes(b"no log at all\n" * 20)
    with pytest.raises(InputError, match=r"cannot be read as|no frame that"):
        open_log(tmp_path / f"a.{ending}", dbc=[tmp_path / "a.dbc"])


@pytest.mark.parametrize(("frame", "extended", "bits"), [(0x900, False, 11), (0x20000100, True, 29)])
def test_an_identifier_of_too_many_bits_is_not_taken_for_another(tmp_path, frame, extended, bits):
    (tmp_path / "a.dbc").write_text(DBC)
    path = write_bus(tmp_path / "a.asc", bus(3))
    lines = path.read_text().splitlines()
    assert sum(" 100 " in line for line in lines) == 3
    path.write_text("\n".join(line.replace(" 100 ", f" {frame:X}{'x' * extended} ") for line in lines))
    with pytest.raises(InputError, match=f"the identifier {frame:#x} at .* has more than {bits} bits"):
        open_log(path, dbc=[tmp_path / "a.dbc"])


def test_times_that_count_from_the_line_before_are_refused(tmp_path):
    (tmp_path / "a.dbc").write_text(DBC)
    path = write_bus(tmp_path / "a.asc", bus(3))
    assert "timestamps absolute" in path.read_text()
    path.write_text(path.read_text().replace("timestamps absolute", "timestamps relative"))
    with pytest.raises(InputError, match="each time of the log counts from the line before it"):
        open_log(path, dbc=[tmp_path / "a.dbc"])
