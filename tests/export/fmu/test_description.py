import pytest

from polydraulic.errors import InputError
from polydraulic.export.fmu.description import FmuDescription, FmuVariable, free_name

WHAT = FmuDescription(
    "f",
    (
        FmuVariable("u", "input"),
        FmuVariable("k", "parameter"),
        FmuVariable("v", "input"),
        FmuVariable("y", "output"),
        FmuVariable("z", "output", dependencies=("v",)),
        FmuVariable("t", "output", dependencies=()),
    ),
)


def test_places_are_value_references():
    assert WHAT.of_kind("input") == [0, 2]
    assert WHAT.of_kind("output") == [3, 4, 5]
    assert WHAT.of_kind("fixed parameter") == []


def test_an_output_depends_on_all_inputs_unless_it_names_them():
    assert [WHAT.depends_on(output) for output in (3, 4, 5)] == [[0, 2], [2], []]


def test_variables_need_different_names():
    with pytest.raises(InputError, match="they must differ"):
        FmuDescription("f", (FmuVariable("a", "input"), FmuVariable("a", "output")))


def test_a_name_that_is_taken_gets_underscores():
    assert free_name("time", ["u", "y"]) == "time"
    assert free_name("time", ["time", "time_"]) == "time__"
