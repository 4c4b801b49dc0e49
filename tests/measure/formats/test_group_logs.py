"""What MDF, MAT, CAN and ROS logs hold, case by case, as the documentation lists it."""

import pytest

from helpers.group_log_kinds import READ, REFUSED, cases, databases
from polydraulic.errors import InputError
from polydraulic.measure import import_log, open_log
from polydraulic.measure.channels import channel_map

NAMED = {"status", "not read", "short frame", "duplicate", "text", "stamps", "unstamped", "infinite"}


@pytest.mark.parametrize(
    ("group", "what", "write", "channel", "came"), cases(), ids=lambda value: "" if callable(value) else str(value)[:40]
)
def test_what_comes_of_each_kind_of_log(tmp_path, group, what, write, channel, came):
    path, dbc = write(tmp_path), databases(tmp_path, group)
    channels = [{"source": channel, "role": "input", "unit": "bar", "kind": "pressure"}]
    if group == "MAT":
        channels.append(
            {"source": channel.replace("p", "time") if channel == "p" else "out.time", "role": "time", "unit": "s"}
        )
    given = channel_map({"raster": "10 ms", "channel": channels})
    if came == REFUSED:
        with pytest.raises(InputError, match="log"):
            import_log(path, given, tmp_path / "t.parquet", dbc=dbc)
        return
    found = import_log(path, given, tmp_path / "t.parquet", dbc=dbc)
    with open_log(path, dbc=dbc) as log:
        assert log.signal(channel).name
    kinds = {
        finding.kind for finding in found.findings if finding.channel in ("", channel, channel.rpartition("/")[0])
    } & NAMED
    expected = set() if came == READ else set(came)
    if dbc:  # the bus has frames that its database does not know
        kinds, expected = kinds - {"not read"} | (kinds & expected), expected
    assert kinds == expected
    assert found.n_row or what.startswith(("multiplexed", "values"))
