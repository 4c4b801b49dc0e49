import pytest

from polydraulic import load_machine
from polydraulic.identification.equations.identified_file import Identified, file_text, machine_data
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.load import machine_names, machine_path

LAYOUTS = machine_names()


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_machine_is_written_as_it_is(name, tmp_path):
    machine, path = load_machine(name), tmp_path / "written.toml"
    for data in (machine_data(machine), read_toml(machine_path(name))):
        path.write_text(file_text(data, {}, ["of a test"]), encoding="utf-8")
        assert load_machine(path) == machine


def test_what_was_identified_stands_in_the_units_of_the_file(tmp_path):
    name, path = "cat215b_bucket", tmp_path / "written.toml"
    new = {
        "functions.boom.valve.inlet": Identified(
            [0.0, 0.0, 1e-6, 2e-6, 2e-6, 3e-6], [0.0, 0.0, 1e-8, 1e-8, 1e-8, float("inf")], 'from "a log"'
        ),
        "gravity": Identified(9.8, 0.01, "weighed"),
    }
    path.write_text(file_text(read_toml(machine_path(name)), new, []), encoding="utf-8")
    found, data = load_machine(path), read_toml(path)
    assert found.function("boom").valve.inlet == pytest.approx(new["functions.boom.valve.inlet"].value, rel=1e-9)
    entry = data["functions"]["boom"]["valve"]["inlet"]
    assert (entry["unit"], entry["source"]) == ("in3/s/psi^0.5", 'from "a log"')
    assert entry["uncertainty"][-1] == float("inf")
    assert entry["uncertainty"][2] / entry["value"][2] == pytest.approx(0.01)
    assert found._replace(gravity=9.81, functions=()) == load_machine(name)._replace(functions=())
    assert data["gravity"]["uncertainty"] == 0.01
