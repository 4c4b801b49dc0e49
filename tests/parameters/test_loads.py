import numpy as np
import pytest

from polydraulic import InputError, load_scenario
from polydraulic.parameters.loads import Loads, Payload

SCENARIO = """
title = "Load"
source = "made up"
duration = {value = 2, unit = "s", source = "made up"}
[voltage]
[force.z]
kind = "constant"
force = {value = -1, unit = "kN", source = "made up"}
[force.x]
kind = "piecewise"
time = {value = [0, 2], unit = "s", source = "made up"}
force = {value = [0, 500], unit = "N", source = "made up"}
[payload]
time = {value = [500, 1500], unit = "ms", source = "made up"}
mass = {value = [0.2, 0], unit = "t", source = "made up"}
"""


def load(folder, text=SCENARIO):
    path = folder / "load.toml"
    path.write_text(text, encoding="utf-8")
    return load_scenario(path)


def test_forces_and_payloads_arrive_in_si(tmp_path):
    loads = load(tmp_path).loads
    assert np.array_equal(loads.forces(np.array([0.0, 1.0])), [[0.0, 0.0, -1000.0], [250.0, 0.0, -1000.0]])
    assert loads.payload == Payload((0.5, 1.5), (200.0, 0.0))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[force.z]", "[force.up]", "unknown key 'up' in force"),
        ('unit = "kN"', 'unit = "kg"', "force.z.force has unit 'kg'"),
        (
            'kind = "constant"',
            'kind = "step"',
            r"force.z.kind = 'step': must be one of \['constant', 'piecewise', 'sine'\]",
        ),
        ("[500, 1500]", "[1500, 500]", "the times of a payload must rise"),
        ("[0.2, 0]", "[0.2]", "2 times, 1 masses"),
        ("[0.2, 0]", "[-0.2, 0]", r"payload.mass\[0\]"),
    ],
)
def test_doubtful_loads_are_refused(tmp_path, old, new, words):
    with pytest.raises(InputError, match=words):
        load(tmp_path, SCENARIO.replace(old, new))


def test_no_loads_are_no_forces():
    assert Loads().forces(np.zeros(2)).tolist() == [[0.0] * 3] * 2
