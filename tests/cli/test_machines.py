"""`polydraulic machine ...` and other commands with a machine of one's own, as a user calls them."""

from importlib.resources import files
from pathlib import Path

import pytest

from helpers.small_crane import crane_text, crane_text_with_effects, write_crane
from polydraulic import load_machine, read_table

OLDER = Path(__file__).parents[1] / "parameters" / "layout" / "data" / "cat215b_older.toml"


def test_the_machines_of_the_package_are_listed_with_what_moves_them(call):
    code, out, _ = call("machine list")
    assert code == 0
    assert "loader_crane" in out
    assert "moved by slew, inner, outer, reach, tilt" in out
    code, out, _ = call("machine list --circuits")
    assert code == 0
    assert out.startswith("series")


def test_a_good_file_is_described_and_doubtful_values_are_warned_of(call, tmp_path):
    write_crane(tmp_path, 'pump.relief = {value = 250, unit = "bar"', 'pump.relief = {value = 250, unit = "psi"')
    code, out, _ = call("machine check crane.toml")
    assert code == 0
    assert "  boom: revolute about -y on column, 250 kg" in out
    assert "warning: circuits.main.pump.relief = 17.24 bar: usual is 50 bar to 500 bar" in out
    assert "\n  extend: stroke 1400 mm, " in out
    assert (
        "bar hold it at its initial position, but circuits.main.pump.relief is 17.24 bar, so that it is not raised"
        in out
    )
    assert out.rstrip().endswith("crane.toml: good")


def test_all_that_is_wrong_is_printed_in_one_error(call, tmp_path):
    write_crane(tmp_path, 'axis = "-y"', 'axis = "up"')
    code, out, err = call("machine check crane.toml")
    assert (code, out) == (2, "")
    assert err.startswith("error: crane.toml: links.boom.axis = 'up'")


def test_a_scenario_is_no_machine(call, tmp_path):
    (tmp_path / "s.toml").write_bytes(
        files("polydraulic").joinpath("parameters", "scenarios", "task.toml").read_bytes()
    )
    code, out, err = call("machine check s.toml")
    assert (code, out) == (2, "")
    assert err == "error: s.toml: is a scenario, not a machine; run it by `polydraulic simulate s.toml`\n"


def test_circuits_offered_are_those_of_the_machine(call, tmp_path):
    write_crane(tmp_path)
    code, _, err = call("sample --circuit lift --machine crane.toml --rows 5 --out s.csv")
    assert (code, err) == (2, "error: unknown circuit 'lift'; choose one of ['main', 'second']\n")


def test_a_new_file_is_a_machine_and_overwrites_nothing(call, tmp_path):
    assert call("machine new mine.toml --like loader_crane")[0] == 0
    assert load_machine(tmp_path / "mine.toml") == load_machine("loader_crane")
    assert call("machine new --like loader_crane")[1] == (tmp_path / "mine.toml").read_text(encoding="utf-8")
    code, _, err = call("machine new mine.toml")
    assert code == 2
    assert "mine.toml is there already" in err
    code, _, err = call("machine", "new", "other.toml", "--like", OLDER)
    assert code == 2
    assert "older form" in err
    assert not (tmp_path / "other.toml").exists()


def test_the_kernels_of_a_layout_are_shown(call, tmp_path):
    write_crane(tmp_path)
    code, out, _ = call("machine show crane.toml")
    assert code == 0
    compile(out, "shown", "exec")
    assert "pilot_step(x.slew, voltage.slew, plant.slew.pilot)" in out
    code, out, _ = call("machine show crane.toml --methods")
    assert code == 0
    compile(out, "shown", "exec")
    assert "def run_rosenbrock(" in out


def test_methods_that_would_refuse_a_machine_are_not_shown_for_it(call, tmp_path):
    (tmp_path / "effects.toml").write_text(crane_text_with_effects(), encoding="utf-8")
    code, out, err = call("machine show effects.toml --methods")
    assert (code, out) == (2, "")
    assert "does not know it; use 'semi-implicit', or leave it out" in err
    code, out, _ = call("machine check effects.toml")
    assert code == 0
    assert "methods of simulate: semi-implicit alone" in out


def test_a_machine_of_ones_own_is_simulated_recorded_and_refused_where_it_must_be(call, tmp_path):
    write_crane(tmp_path)
    code, out, err = call("simulate random:3:2 --machine crane.toml --energy --out run.parquet")
    assert code == 0, err
    assert "slew" in out
    assert "at the end: slew" in out
    run = read_table(tmp_path / "run.parquet")
    assert run.unit("energy.kinetic") == "J"
    assert run.unit("extend.position") == "m"
    code, _, err = call("simulate random:3:2 --machine crane.toml --flow pressure")
    assert code == 2
    assert "fit one of 'main.p_pump' on a sampled table first" in err
    assert call("record --example --machine crane.toml --out sensors.toml")[0] == 0
    code, out, err = call("record random:3:2 --machine crane.toml --sensors sensors.toml --out log.csv")
    assert code == 0, err
    log = (tmp_path / "log.csv").read_text(encoding="utf-8").split("\n")[0]
    assert "extend.position [mm]" in log
    assert "lift.angle [deg]" in log


@pytest.mark.parametrize("name", ["class", "a b", "9"])
def test_names_that_are_no_names_never_become_code(call, tmp_path, name):
    text = crane_text().replace("[functions.slew]", f'[functions."{name}"]').replace('"slew"', f'"{name}"')
    (tmp_path / "crane.toml").write_text(text, encoding="utf-8")
    code, _, err = call("machine show crane.toml")
    assert code == 2
    assert f"functions.{name}: the name {name!r}" in err
