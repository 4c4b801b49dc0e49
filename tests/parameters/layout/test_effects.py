"""Effects that a machine file may declare: read in any unit, absent unless declared, refused and warned of by name."""

import pytest

from helpers.small_crane import crane_text_with_effects, write_crane
from polydraulic import InputError, load_machine
from polydraulic.parameters.layout.describe import described
from polydraulic.parameters.layout.parts import Effects, FlowForce
from polydraulic.parameters.layout.usual import unusual


def written(folder, old="", new=""):
    text = crane_text_with_effects()
    assert old in text
    path = folder / "effects.toml"
    path.write_text(text.replace(old, new) if old else text, encoding="utf-8")
    return path


def test_effects_arrive_in_si_and_are_listed(tmp_path):
    crane = load_machine(written(tmp_path))
    force = FlowForce(pytest.approx(30e3), 870.0, pytest.approx(1.2042771838760873))
    assert crane.function("lift").effects == (
        True,
        pytest.approx(0.3 * 0.017453292519943295),
        pytest.approx(3e-4),
        force,
    )
    assert crane.function("extend").effects.backlash == pytest.approx(3e-4)
    said = next(line for line in described(crane) if line.startswith("  extend:"))
    assert said.endswith("; with friction.sticks, backlash, valve.hysteresis, valve.flow_force")
    assert unusual(crane) == []


def test_nothing_is_declared_by_itself(tmp_path):
    crane = load_machine(write_crane(tmp_path))
    assert [f.effects for f in crane.functions] == [Effects()] * 3
    assert Effects().declared == ()
    assert Effects(hysteresis=0.0).declared == ("valve.hysteresis",)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('hysteresis = {value = 0.3, unit = "mm"', 'hysteresis = {value = -0.3, unit = "mm"', "slew.valve.hysteresis = -0.3 mm"),
        ('hysteresis = {value = 0.3, unit = "mm"', 'hysteresis = {value = 9, unit = "mm"', "below the full travel"),
        ('backlash = {value = 0.3, unit = "deg"', 'backlash = {value = 400, unit = "deg"', "below the way between the stops"),
        ('backlash = {value = 0.3, unit = "deg"', 'backlash = {value = 0.3, unit = "mm"', "functions.lift.backlash has unit 'mm'"),
        ('sticks = {value = true', 'sticks = {value = 1', "functions.slew.friction.sticks = 1: must be true or false"),
        ('valve.flow_force.density = {value = 870, unit = "kg/m3", source = "made up"}\n', "", "missing key 'density' in functions.slew.valve.flow_force"),
        ('valve.flow_force.density', "valve.flow_force.thickness", "unknown key 'thickness'"),
        ('jet_angle = {value = 69', 'jet_angle = {value = 91', "slew.valve.flow_force.jet_angle = 91 deg"),
        ("friction.sticks", "friction.stiks", "unknown key 'stiks' in functions.slew.friction; allowed here: ['coulomb', 'smoothing', 'static', 'sticks', "),
        ("friction.static = {value = 600.0", "friction.static = {value = 300.0", "slew.friction.static = 300: must be at least coulomb"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_by_name(tmp_path, old, new, said):
    with pytest.raises(InputError) as error:
        load_machine(written(tmp_path, old, new))
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('spring_rate = {value = 30, unit = "N/mm"', 'spring_rate = {value = 30, unit = "N/m"', "slew.valve.flow_force.spring_rate"),
        ("density = {value = 870", "density = {value = 87", "slew.valve.flow_force.density"),
        ('hysteresis = {value = 0.3, unit = "mm"', 'hysteresis = {value = 3, unit = "mm"', "slew.valve.hysteresis"),
        ('backlash = {value = 0.3, unit = "mm"', 'backlash = {value = 30, unit = "mm"', "extend.backlash"),
        ('backlash = {value = 0.3, unit = "deg"', 'backlash = {value = 3, unit = "deg"', "slew.backlash"),
    ],
)  # fmt: skip
def test_what_is_unusual_is_named(tmp_path, old, new, said):
    found = unusual(load_machine(written(tmp_path, old, new)))
    assert found
    assert found[0].startswith(f"functions.{said} = ")
