import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import InputError, load_machine, load_scenario
from polydraulic.parameters.layout.adapt import adapted, at_full_stroke, full_stroke

SCENARIO = """
title = "Lift"
source = "made up"
duration = {value = 2, unit = "s", source = "made up"}
[voltage.lift]
kind = "constant"
voltage = {value = 0.5, unit = "V", source = "made up"}
[change.extend.initial]
position = {value = 900, unit = "mm", source = "made up"}
[change.lift.pilot]
dead_time = {value = 50, unit = "ms", source = "made up"}
"""


@pytest.fixture
def crane(tmp_path):
    return load_machine(write_crane(tmp_path))


def scenario(folder, crane, text=SCENARIO):
    path = folder / "lift.toml"
    path.write_text(text, encoding="utf-8")
    return load_scenario(path, functions=crane.names)


def test_pilots_and_initial_states_of_functions_are_changed(tmp_path, crane):
    found = adapted(crane, scenario(tmp_path, crane))
    assert found.function("extend").initial.angle == pytest.approx(0.9)
    assert found.function("extend").initial.p_a == crane.function("extend").initial.p_a
    assert found.function("lift").pilot.dead_time == pytest.approx(0.05)
    assert found.function("slew") == crane.function("slew")


def test_a_state_beyond_the_stops_and_a_function_that_is_not_there_are_refused(tmp_path, crane):
    with pytest.raises(InputError, match=r"functions\.extend\.initial\.position = 9000 mm: must be within the stops"):
        adapted(crane, scenario(tmp_path, crane, SCENARIO.replace("900,", "9000,")))
    with pytest.raises(InputError, match="unknown key 'boom'"):
        scenario(tmp_path, crane, SCENARIO.replace("voltage.lift", "voltage.boom"))
    with pytest.raises(InputError, match="unknown key 'boom' in change"):
        scenario(tmp_path, crane, SCENARIO.replace("change.lift", "change.boom"))


def test_full_stroke_drives_every_spool_to_its_end(crane):
    limit = full_stroke(crane)
    assert all(f.pilot.gain * limit > f.valve.knots[-1] for f in crane.functions)
    assert at_full_stroke("random:3:9", crane) == f"random:3:9:{limit:.6g}"
    assert at_full_stroke("random:3", crane) == f"random:3:60:{limit:.6g}"
    assert at_full_stroke("random:3:9:0.5", crane) == "random:3:9:0.5"
    assert at_full_stroke("task", crane) == "task"
    highest = np.abs(load_scenario("random:3:60:0.5").voltages(np.arange(0.0, 60.0, 0.01))).max()
    assert 0.4 < highest <= 0.5
