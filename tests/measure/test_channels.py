import tomllib

import pytest

from helpers.logs_made import MAP
from polydraulic.errors import InputError
from polydraulic.measure.channels import channel_map, load_channels

FLOW = """
[[channel]]
source = "stroke"
role = "input"
unit = "mm"
[[flow]]
name = "q"
position = "stroke"
area = "12 cm2"
pressure = "boom.p_a"
compliance = "0.002 l/bar"
"""


def test_a_map_is_read():
    found = channel_map(tomllib.loads(MAP + FLOW))
    assert found.raster == pytest.approx(0.01)
    assert found.time.source == "time"
    assert [c.name for c in found.used] == ["lever", "boom.p_a", "speed", "stroke"]
    assert found.of_role("output") == ["speed", "q"]
    pressure = found.used[1]
    assert (pressure.low, pressure.high, pressure.unit, pressure.between, pressure.sign) == (5, 250, "bar", "linear", 1)
    assert found.used[0].raster is None
    flow = found.flows[0]
    assert (flow.area, flow.compliance, flow.window) == pytest.approx((12e-4, 2e-11, 0.1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('raster = "10 ms"\n\n', ""), "missing key 'raster'"),
        (('raster = "10 ms"\n\n', 'raster = "10 bar"\n'), "raster = '10 bar': must be in s"),
        (('raster = "10 ms"\n\n', 'raster = "0 ms"\n'), "raster = '0 ms': must lie in"),
        (('raster = "10 ms"\n\n', 'raster = 10\n'), "must be a number with its unit"),
        (('role = "output"', 'role = "result"'), "role of channel 'speed' = 'result': must be one of"),
        (('role = "output"', ""), "missing key 'role' in channel 4"),
        (('role = "output"', 'role = "output"\nunits = "bar"'), "unknown key 'units' in channel 4"),
        (('role = "output"', 'role = "time"'), "the time channel 'speed'|time needs a unit of time"),
        (('unit = "mm/s"', 'unit = "mm per s"'), "unit of channel 'speed': unknown unit 'mm per s'"),
        (('unit = "mm/s"', "unit = 5"), "unit of channel 'speed' = 5"),
        (("[5, 250]", "[250, 5]"), r"range of channel 'p_head' = \[250, 5\]: must be \[low, high\]"),
        (("[5, 250]", "[5]"), "range of channel 'p_head'"),
        (("[5, 250]", "[nan, 5]"), "range of channel 'p_head'"),
        (('"boom.p_a"', '"lever"'), "two channels have the name 'lever'"),
        (('"boom.p_a"', '"segment"'), "the table has a column of this name already"),
        (('source = "p_head"', 'source = "lever"'), "two channels have the source 'lever'|two channels have the name"),
        (('unit = "bar"', 'unit = "bar"\nsign = 2'), "sign of channel 'p_head' = 2: must be 1 or -1"),
        (('unit = "bar"', 'unit = "bar"\nbetween = "spline"'), "must be one of"),
        (('unit = "s"', 'unit = "bar"'), "time needs a unit of time"),
        (('raster = "10 ms"\n\n[[channel]]\nsource = "time"', 'raster = "10 ms"\ninterval = "5 ms"\n[[channel]]\nsource = "time"'), "interval is given too"),
        (('role = "input"', 'role = "ignore"'), "output"),
        (('"12 cm2"', '"12 bar"'), "area of flow 'q' = '12 bar': must be in m2"),
        (('position = "stroke"', 'position = "lever"'), "is in V; it must be in m"),
        (('position = "stroke"', 'position = "strokes"'), "no such column"),
        (('pressure = "boom.p_a"', ""), "pressure and compliance go together"),
        (('"0.002 l/bar"', '"-0.002 l/bar"'), "compliance not negative"),
        (('area = "12 cm2"', 'area = "12 cm2"\nwindow = "5 ms"'), "three rasters of the table"),
        (('name = "q"', 'name = "speed"'), "two channels have the name 'speed'"),
        (('raster = "10 ms"\n\n[[channel]]\nsource = "time"', 'raster = "10 ms"\natmosphere = "10 bar"\n[[channel]]\nsource = "time"'), r"atmosphere = '10 bar': must lie in \[0.3, 1.2\] bar"),
        (('raster = "10 ms"\n\n[[channel]]\nsource = "time"', 'raster = "10 ms"\natmosphere = "1 m"\n[[channel]]\nsource = "time"'), "atmosphere = '1 m': must be in Pa"),
        (('raster = "10 ms"\n\n[[channel]]\nsource = "time"', 'raster = "10 ms"\natmosphere = 1.0\n[[channel]]\nsource = "time"'), "atmosphere = 1.0: must be a number with its unit"),
        (('unit = "bar"', 'unit = "l/min"'), "unit of channel 'p_head' = 'l/min' measures flow, but its name 'boom.p_a' says pressure: give a unit such as 'psi'"),
        (('unit = "bar"', 'unit = "mA"'), "measures current, but .* or what is measured as kind = 'current'"),
        (('unit = "bar"', 'unit = "kg/m3"'), "measures density, but"),
        (('source = "p_head"\nname = "boom.p_a"', 'source = "x"\nname = "boom.p_a"'), "its name 'boom.p_a' says pressure"),
        (('unit = "bar"', 'unit = "bar"\nkind = "flow"'), "unit of channel 'p_head' = 'bar' measures pressure, but its kind says flow"),
        (('unit = "bar"', 'unit = "bar"\nkind = "force of habit"'), "kind of channel 'p_head' = 'force of habit': must be one of"),
        (('unit = "mm/s"', 'kind = "speed"'), "channel 'speed' has no unit, but its kind says speed: give its unit"),
        (('unit = "mm/s"', 'unit = ""\nkind = "speed"'), "unit of channel 'speed' = '' measures number, but its kind says speed"),
        (('unit = "bar"\n', ""), "channel 'p_head' has no unit, but its name 'boom.p_a' says pressure: give its unit, or unit = \"\" for"),
        (('unit = "mm/s"', 'unit = "kg/cm2"'), "unit of channel 'speed': unit 'kg/cm2' is a unit of mass, not of force: write 'kgf/cm2' for a pressure"),
        (('unit = "mm/s"', 'unit = "g"'), "unit of channel 'speed': unit 'g' can be read in several ways; write gn or g0"),
        (('pressure = "boom.p_a"', 'pressure = "lever"'), "pressure of flow 'q' = 'lever' is in V; it must be in Pa"),
    ],
)  # fmt: skip
def test_a_bad_map_is_one_error(tmp_path, change, message):
    text = (MAP + FLOW).replace(*change)
    if "boom.p_a" in change[0] and "source" in change[0]:
        text = text.replace('unit = "bar"', 'unit = "mm"')
    if change[1] == 'role = "ignore"':
        text = text.replace('role = "output"', 'role = "ignore"').partition("[[flow]]")[0]
        message = "no channel has the role 'input' or 'output'"
    assert text != MAP + FLOW
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_channels(tmp_path / "map.toml")
    assert "map.toml" in str(caught.value)


def channel(**keys):
    return channel_map({"raster": "10 ms", "channel": [{"role": "input", "source": "x", **keys}]}).used[0]


@pytest.mark.parametrize(
    ("key", "good", "bad", "said"),
    [
        ("raster", ["1 us", "100000 s"], ["0.99 us", "100001 s"], "raster = '{}': must lie in \\[1e-06, 100000\\] s"),
        (
            "interval",
            ["1 us", "100000 s"],
            ["0.99 us", "100001 s"],
            "interval = '{}': must lie in \\[1e-06, 100000\\] s",
        ),
        (
            "atmosphere",
            ["0.3 bar", "1.2 bar"],
            ["0.299 bar", "1.201 bar"],
            "atmosphere = '{}': must lie in \\[0.3, 1.2\\] bar",
        ),
    ],
)
def test_ends_of_what_is_allowed_are_allowed(key, good, bad, said):
    data = {"raster": "10 ms", "channel": [{"role": "input", "source": "x", "unit": "mm"}]}
    for value in good:
        channel_map({**data, key: value})
    for value in bad:
        with pytest.raises(InputError, match=said.format(value)):
            channel_map({**data, key: value})


def test_a_range_goes_as_far_as_its_squares_are_numbers():
    assert channel(unit="mm", range=[-1e100, 1e100]).high == 1e100
    for ends in ([-1.01e100, 0.0], [0.0, 1.01e100]):
        with pytest.raises(InputError, match=r"two numbers in the channel's unit of at most 1e\+100, low below high"):
            channel(unit="mm", range=ends)


def test_pressures_are_known_by_kind_name_and_flows():
    assert channel(unit="kg/cm2", kind="pressure").kind == "Pa"
    assert channel(unit="kg/cm2", source="p_head").kind == "Pa"
    assert channel(unit="mA", source="p_head", kind="current").kind == "A"
    assert channel(source="p_head", unit="").unit == ""  # plain numbers where the map says so
    assert channel(unit="mm").kind == ""
    found = channel_map(tomllib.loads((MAP + FLOW).replace('"boom.p_a"', '"y"').replace('"p_head"', '"z"')))
    assert [c.kind for c in found.used] == ["", "Pa", "", ""]


@pytest.mark.parametrize(
    ("text", "pascal"), [("1.01325 bar", 101325.0), ("0.95 bar(a)", 95e3), ("14.5 psia", 99973.98), ("980 hPa", 98e3)]
)
def test_the_atmosphere_is_read_as_absolute(text, pascal):
    data = {"raster": "10 ms", "atmosphere": text, "channel": [{"role": "input", "source": "p_a", "unit": "bara"}]}
    found = channel_map(data)
    assert found.atmosphere == pytest.approx(pascal, rel=1e-6)
    assert found.conversion(found.used[0]).to_si(2.0) == pytest.approx(2e5 - pascal, rel=1e-6)


def test_a_missing_map_says_how_to_get_one(tmp_path):
    with pytest.raises(InputError, match="no such file; `polydraulic import --suggest LOG` writes a first one"):
        load_channels(tmp_path / "map.toml")


@pytest.mark.parametrize("value", ["9" * 400, "1e308", "-1e308", "[[]]", "{}", "[1e308, inf]", '"1e308 m"', "x = 1"])
def test_strange_values_anywhere_in_a_map_are_one_error(value, tmp_path):
    lines = (MAP + FLOW).splitlines()
    places = [
        k
        for k, line in enumerate(lines)
        if " = " in line and line.split(" = ")[0] not in ("source", "name", "position", "pressure")
    ]
    for k in places:
        path = tmp_path / "map.toml"
        path.write_text("\n".join([*lines[:k], f"{lines[k].split(' = ')[0]} = {value}", *lines[k + 1 :]]))
        with pytest.raises(InputError, match="map.toml"):
            load_channels(path)


RATE = """
[[derivative]]
name = "stroke.rate"
of = "stroke"
window = "50 ms"
"""


def test_rates_have_units_of_their_own():
    found = channel_map(tomllib.loads(MAP + FLOW + RATE))
    assert found.of_role("output") == ["speed", "q", "stroke.rate"]
    assert found.made() == {"q": "m3/s", "stroke.rate": "m/s"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"50 ms"', '"20 ms"'), "window of derivative 'stroke.rate' = 0.02 s: must be 0.03 s at least, three rasters"),
        (('of = "stroke"', 'of = "lever"'), "of in derivative 'stroke.rate' = 'lever' is in V; it must be in one of"),
        (('of = "stroke"', 'of = "strike"'), "'strike': no such column"),
        (('unit = "mm"', 'unit = "mm"\nbetween = "hold"'), "'stroke' is held between its samples: steps have no rate"),
        (('unit = "mm"', 'unit = "mm"\nraster = "20 ms"'), "must be 0.06 s at least"),
        (('name = "stroke.rate"', 'name = "time"'), "derivative 'time': the table has a column of this name"),
        (('name = "stroke.rate"', 'name = "q"'), "two channels have the name 'q'"),
        (('window = "50 ms"', ""), "missing key 'window' in derivative 1"),
    ],
)
def test_doubtful_rates_are_refused(change, message):
    text = (MAP + FLOW + RATE).replace(*change)
    assert text != MAP + FLOW + RATE
    with pytest.raises(InputError, match=message):
        channel_map(tomllib.loads(text))


@pytest.mark.parametrize("raster", [1, 7, 10, 13, 100, 700])
def test_a_window_of_exactly_three_rasters_is_long_enough(raster):
    def read(flow, rate):
        flows = FLOW.replace("compliance", f'window = "{flow * raster} ms"\ncompliance')
        rates = RATE.replace("50 ms", f"{rate * raster} ms")
        return channel_map(tomllib.loads((MAP + flows + rates).replace('"10 ms"', f'"{raster} ms"')))

    read(3, 3)
    for windows, short in (((2.999, 3), "flow 'q'"), ((3, 2.999), "derivative 'stroke.rate'")):
        with pytest.raises(InputError, match=f"window of {short} = .* s: must be"):
            read(*windows)
