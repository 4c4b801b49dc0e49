import pytest

from polydraulic.parameters.layout.names import name_trouble


@pytest.mark.parametrize("name", ["boom", "arm_1", "X", "a" * 40, "count", "sin", "main"])
def test_usual_names_are_taken(name):
    assert name_trouble(name) == ""


@pytest.mark.parametrize(
    "name",
    ["", "1st", "a" * 41, "böm", "a-b", "a b", "_a", "a__b", "a_", "lambda", "None", "match", "int", "Register", "time", "effector", "ground", 3, None,
     "a\n", "import os"],
)  # fmt: skip
def test_other_names_are_refused_with_a_reason(name):
    assert name_trouble(name)
