from types import SimpleNamespace

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.mdf.mdf_log import rows_fit, within_rows


def test_invalid_samples_of_an_mdf_are_missing(tmp_path):
    from asammdf import MDF, Signal

    time = np.arange(10) * 0.1
    with MDF(version="4.10") as file:
        file.append([Signal(time, time, "V", "a", invalidation_bits=np.arange(10) == 3)], common_timebase=True)
        file.save(tmp_path / "a.mf4")
    with open_log(tmp_path / "a.mf4") as log:
        (block,) = log.read(0, ["a"], None, Findings())
    assert np.flatnonzero(np.isnan(block.values["a"])).tolist() == [3]


def test_raw_numbers_and_texts_of_an_mdf(tmp_path):
    from asammdf import MDF, Signal

    time = np.arange(10) * 0.1
    linear = {"a": 2.0, "b": 5.0}
    names = {f"val_{k}": k for k in range(2)} | {f"text_{k}": name for k, name in enumerate((b"off", b"on"))}
    with MDF(version="4.10") as file:
        raw = np.arange(10, dtype=np.uint8)
        file.append([
            Signal(raw, time, "V", "scaled", conversion=linear),
            Signal(raw % 2, time, "", "state", conversion=names),
            Signal(np.array([b"x"] * 10), time, "", "words", encoding="utf-8"),
        ], common_timebase=True)  # fmt: skip
        file.save(tmp_path / "a.mf4")
    with open_log(tmp_path / "a.mf4") as log:
        (block,) = log.read(0, ["scaled", "state", "words"], None, Findings())
    assert block.time == pytest.approx(time)
    assert block.values["scaled"] == pytest.approx(2.0 * np.arange(10) + 5.0)
    assert block.values["state"].tolist() == [0, 1] * 5
    assert block.text["words"].tolist() == list(range(10))
    assert np.all(np.isnan(block.values["words"]))


def mdf(path, *groups, version="4.10"):
    """Write an MDF log of groups of channels, each a list of signals or (list, name of the group)."""
    from asammdf import MDF

    with MDF(version=version) as file:
        for group in groups:
            signals, name = group if isinstance(group, tuple) else (group, None)
            file.append(signals, acq_name=name, common_timebase=True)
        saved = file.save(path, overwrite=True)
    return saved.rename(path)  # the library has its own mind about endings


def table(default=None, **keys):
    """Build a conversion of values or ranges to texts."""
    from asammdf.blocks.conversion_utils import from_dict

    if isinstance(default, tuple):
        default = from_dict({"a": default[0], "b": default[1]})
    return from_dict(keys | ({} if default is None else {"default_addr": default}))


def only(path, name, findings=None):
    with open_log(path) as log:
        blocks = list(log.read(log.signal(name).group, [name], None, Findings() if findings is None else findings))
    return np.concatenate([b.values[name] for b in blocks])


@pytest.mark.parametrize("n", [20, 400])  # the reader has other ways for short and for long blocks
@pytest.mark.parametrize("every", [1, 5, 1000])
def test_status_codes_beside_a_scaling_are_missing_and_named(tmp_path, n, every):
    from asammdf import Signal

    time = np.arange(n) * 0.01
    raw = (np.arange(n) % 100).astype(np.uint8)
    expected = 0.4 * raw - 40.0
    raw[::every], expected[::every] = 254, np.nan
    raw[3], expected[3] = 255, np.nan
    codes = table((0.4, -40.0), val_0=254, text_0="error", val_1=255, text_1="not available")
    findings = Findings()
    found = only(mdf(tmp_path / "a.mf4", [Signal(raw, time, "degC", "T", conversion=codes)]), "T", findings)
    assert found == pytest.approx(expected, nan_ok=True)
    (status,) = findings.of("status", "T")
    assert status.count == np.isnan(expected).sum()
    assert "'error'" in str(status) or every == 1000
    assert "'not available'" in str(status)


@pytest.mark.parametrize("n", [20, 400])
def test_ranges_of_texts_beside_a_scaling_are_missing_and_named(tmp_path, n):
    from asammdf import Signal

    raw = (np.arange(n) % 20 + 1010).astype(np.uint16)
    codes = table(
        (0.1, 0.0), lower_0=1020, upper_0=1022, text_0="reserved", lower_1=1023, upper_1=1023, text_1="no signal"
    )
    findings = Findings()
    found = only(
        mdf(tmp_path / "a.mf4", [Signal(raw, raw * 0.0 + np.arange(n), "bar", "p", conversion=codes)]), "p", findings
    )
    assert found == pytest.approx(np.where((raw >= 1020) & (raw <= 1023), np.nan, 0.1 * raw), nan_ok=True)
    assert "'reserved', 'no signal'" in str(findings.of("status", "p")[0])


def test_ranges_of_scalings_with_a_text_as_default(tmp_path):
    from asammdf import Signal

    raw = np.array([0, 10, 20, 30, 40, 50], dtype=np.uint8)
    two = table(b"outside", lower_0=10, upper_0=19, text_0=table(None, a=2.0, b=0.0), lower_1=20, upper_1=30, text_1=table(None, a=3.0, b=1.0))  # fmt: skip
    findings = Findings()
    found = only(mdf(tmp_path / "a.mf4", [Signal(raw, raw * 0.1, "bar", "p", conversion=two)]), "p", findings)
    assert found == pytest.approx([np.nan, 20.0, 61.0, 91.0, np.nan, np.nan], nan_ok=True)
    assert findings.of("status", "p")[0].count == 3


def test_numbers_of_states_are_values(tmp_path):
    from asammdf import Signal

    raw = np.tile(np.array([0, 1, 2, 3], dtype=np.uint8), 50)
    time = np.arange(200) * 0.1
    switch = table((1.0, 0.0), val_0=0, text_0="off", val_1=1, text_1="on", val_2=2, text_2="error", val_3=3, text_3="not available")  # fmt: skip
    named = table(b"other", val_0=0, text_0="off", val_1=1, text_1="error")
    path = mdf(tmp_path / "a.mf4", [Signal(raw, time, "", "switch", conversion=switch), Signal(raw, time, "", "named", conversion=named)])  # fmt: skip
    findings = Findings()
    assert only(path, "switch", findings)[:4] == pytest.approx([0.0, 1.0, np.nan, np.nan], nan_ok=True)
    assert "'error', 'not available'" in str(findings.of("status", "switch")[0])
    assert only(path, "named")[:4].tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("codes", "lost"),
    [
        ({"val_0": 254, "text_0": "error", "val_1": 255, "text_1": "SNA"}, (254, 255)),
        ({"val_0": 254, "text_0": "error", "val_1": 255, "text_1": "not available", "default": b"fine"}, (254, 255)),
        ({"val_0": 0, "text_0": "off", "val_1": 1, "text_1": "on", "val_2": 255, "text_2": "not available"}, (255,)),
        (
            {"lower_0": 0, "upper_0": 9, "text_0": "low", "lower_1": 250, "upper_1": 255, "text_1": "reserved"},
            (254, 255),
        ),
        ({"val_0": 0, "text_0": "park", "val_1": 3, "text_1": "reverse", "val_2": 255, "text_2": "towed"}, ()),
    ],
)
def test_texts_that_say_that_there_is_no_value_are_none_without_a_scaling_too(tmp_path, codes, lost):
    from asammdf import Signal
    from asammdf.blocks.conversion_utils import from_dict

    raw = np.tile(np.array([0, 1, 3, 254, 255], dtype=np.uint8), 20)
    path = mdf(tmp_path / "a.mf4", [Signal(raw, np.arange(100) * 0.1, "", "p", conversion=from_dict(codes))])
    findings = Findings()
    found = only(path, "p", findings)
    assert found == pytest.approx(np.where(np.isin(raw, lost), np.nan, raw), nan_ok=True)
    assert sum(f.count for f in findings.of("status", "p")) == 20 * len(lost)


@pytest.mark.parametrize(
    ("kind", "unit", "said"), [(2, "deg", "an angle"), (3, "m", "a distance"), (4, "", "an index")]
)
def test_masters_that_are_no_time_are_refused_by_name(tmp_path, kind, unit, said):
    from asammdf import MDF, Signal

    x = np.arange(50.0)
    for name, with_time in (("alone.mf4", False), ("both.mf4", True)):
        with MDF(version="4.10") as file:
            file.append([Signal(x, x, "bar", "p", master_metadata=("crank", kind))], acq_name="cycle")
            file.groups[0].channels[0].unit = unit
            if with_time:
                file.append([Signal(x, x * 0.01, "mm", "x")], acq_name="samples")
            file.save(tmp_path / name)
    with pytest.raises(InputError, match=rf"'cycle' is over 'crank'.*, {said} and no time"):
        open_log(tmp_path / "alone.mf4")
    with open_log(tmp_path / "both.mf4") as log:
        assert [s.name for s in log.signals] == ["x"]
        with pytest.raises(InputError, match=rf"channel 'p' cannot be read: .*'crank'.*, {said} and no time"):
            log.signal("p")


@pytest.mark.parametrize(("version", "ending"), [("4.10", "mf4"), ("3.30", "mdf"), ("3.30", "dat"), ("2.14", "dat")])
def test_every_version_of_mdf_is_read(tmp_path, version, ending):
    from asammdf import Signal

    raw, time = np.arange(30, dtype=np.uint16), np.arange(30) * 0.1
    signals = [Signal(raw, time, "bar", "p", conversion={"a": 0.5, "b": 1.0}),
               Signal(raw % 2, time, "", "s", conversion=table(val_0=0, text_0="off", val_1=1, text_1="on"))]  # fmt: skip
    path = mdf(tmp_path / f"a.{ending}", signals, version=version)
    with open_log(path) as log:
        (block,) = log.read(0, ["p", "s"], None, Findings())
        assert log.signal("p").unit == "bar"
    assert block.time == pytest.approx(time)
    assert block.values["p"] == pytest.approx(0.5 * raw + 1.0)
    assert block.values["s"].tolist() == [0, 1] * 15


def test_one_name_in_two_groups_and_a_group_without_rows(tmp_path):
    from asammdf import Signal

    x = np.arange(20.0)
    path = mdf(tmp_path / "a.mf4", ([Signal(x, x, "bar", "p")], "fast"), ([Signal(2 * x, 2 * x, "bar", "p")], "slow"),
               ([Signal(x[:0], x[:0], "bar", "q")], "none"))  # fmt: skip
    with open_log(path) as log:
        assert [s.name for s in log.signals] == ["p", "slow/p"]
        assert log.duplicates == ["p"]
        assert log.signal("fast/p").group == 0
        for name, group, factor in (("p", 0, 1.0), ("fast/p", 0, 1.0), ("slow/p", 1, 2.0), ("1/p", 1, 2.0)):
            assert log.signal(name).group == group
            assert np.array_equal(only(path, name), factor * x)
        with pytest.raises(InputError, match="channel 'q' cannot be read: group 'none' has no rows"):
            log.signal("q")
        assert log.left_out == {"q": "group 'none' has no rows"}


def test_a_time_in_milliseconds_is_taken_in_seconds(tmp_path):
    from asammdf import MDF, Signal

    x = np.arange(20.0)
    with MDF(version="4.10") as file:
        file.append([Signal(x, x, "bar", "p")])
        file.groups[0].channels[0].unit = "ms"
        file.save(tmp_path / "a.mf4")
    with open_log(tmp_path / "a.mf4") as log:
        (block,) = log.read(0, ["p"], None, Findings())
    assert block.time == pytest.approx(0.001 * x)


@pytest.mark.parametrize(("version", "ending"), [("4.10", "mf4"), ("3.30", "mdf")])
def test_texts_that_are_no_utf_8_are_read(tmp_path, version, ending):
    from asammdf import Signal

    raw, time = np.arange(20, dtype=np.uint16), np.arange(20) * 0.1
    conversion = table((0.1, 0.0), val_0=7, text_0="gestoert") if version > "4" else None
    path = mdf(tmp_path / f"a.{ending}", [Signal(raw, time, "grdC", "p", conversion=conversion)], version=version)
    path.write_bytes(path.read_bytes().replace(b"grdC", b"\xb0C\0\0").replace(b"gestoert", b"gest\xf6rt\0"))
    findings = Findings()
    assert np.nanmax(only(path, "p", findings)) == pytest.approx(1.9 if version > "4" else 19.0)
    with open_log(path) as log:
        assert log.signal("p").unit == "°C"
    assert [f.detail for f in findings.of("status")] == (["'gestört'"] if version > "4" else [])


@pytest.mark.parametrize(("version", "ending"), [("4.10", "mf4"), ("3.30", "mdf")])
def test_a_file_cut_anywhere_is_refused_or_read(tmp_path, version, ending):
    from asammdf import Signal

    x = np.arange(50.0)
    whole = mdf(tmp_path / f"whole.{ending}", [Signal(x, x, "bar", "p")], version=version).read_bytes()
    path = tmp_path / f"a.{ending}"
    refused = 0
    for end in range(0, len(whole), len(whole) // 40):
        path.write_bytes(whole[:end])
        try:
            found = only(path, "p")
        except InputError as error:
            refused += str(error).startswith(str(path))
        else:
            assert np.array_equal(found, x[: len(found)])
    assert refused >= 10


@pytest.mark.parametrize(
    ("version", "channel", "inside"),
    [
        (3, {"start_offset": 0, "bit_count": 64}, True),
        (3, {"start_offset": 8, "bit_count": 64}, False),
        (3, {"start_offset": 0, "additional_byte_offset": 8, "bit_count": 1}, False),
        (4, {"byte_offset": 0, "bit_offset": 0, "bit_count": 64}, True),
        (4, {"byte_offset": 8, "bit_offset": 0, "bit_count": 8}, True),  # among the bits that say what is invalid
        (4, {"byte_offset": 8, "bit_offset": 1, "bit_count": 8}, False),
        (4, {"byte_offset": 1 << 31, "bit_offset": 0, "bit_count": 0}, False),
    ],
)
def test_channels_of_damaged_files_that_are_outside_of_their_rows_are_told(version, channel, inside):
    rows = SimpleNamespace(channel_group=SimpleNamespace(samples_byte_nr=8, invalidation_bytes_nr=1))
    assert within_rows(SimpleNamespace(**channel), rows, version) == inside


def test_more_rows_than_the_file_can_hold_are_told():
    rows = SimpleNamespace(channel_group=SimpleNamespace(samples_byte_nr=8, cycles_nr=100))
    assert rows_fit(rows, 800, 3)
    assert not rows_fit(rows, 799, 3)
    assert rows_fit(rows, 10, 4)  # may be compressed
    rows.channel_group.cycles_nr = 1 << 40
    assert not rows_fit(rows, 1_000_000, 4)


@pytest.mark.parametrize(("version", "most"), [(3, 40_000), (4, 44_000_000)])
def test_a_file_holds_no_more_rows_than_its_bytes_can(version, most):
    """Plain ones of version 3; of version 4 up to 1100 bytes in one that is packed."""
    for rows, fits in ((most // 8, True), (most // 8 + 1, False)):
        group = SimpleNamespace(channel_group=SimpleNamespace(cycles_nr=rows, samples_byte_nr=8))
        assert rows_fit(group, 40_000, version) == fits
