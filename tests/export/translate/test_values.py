import math

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.export.translate.types import BOOL, FLOAT, INT, Array
from polydraulic.export.translate.values import (
    PRODUCT,
    SUM,
    UNARY,
    Value,
    as_float,
    kind_of,
    literal_value,
    number,
    plain,
    shown,
)


def test_an_operand_gets_brackets_where_it_binds_less():
    total = Value("a + b", FLOAT, SUM)
    assert total.inside(SUM) == "a + b"
    assert total.inside(PRODUCT) == "(a + b)"


@pytest.mark.parametrize(
    ("value", "text"),
    [(True, "true"), (np.False_, "false"), (3, "3"), (2**40, "INT64_C(1099511627776)"), (0.1, "0.1"), (2.0, "2.0"),
     (math.inf, "HUGE_VAL"), (-math.inf, "-HUGE_VAL"), (1e300, "1e+300")],
)  # fmt: skip
def test_numbers_read_back_exactly(value, text):
    assert number(value) == text


def test_what_is_no_number_is_refused_by_name():
    with pytest.raises(InputError, match="boom_mass is not a number"):
        number(math.nan, "boom_mass")


def test_literals_know_their_type_and_whether_they_are_negative():
    assert [kind_of(value) for value in (True, 1, 1.0)] == [BOOL, INT, FLOAT]
    assert literal_value(-2.0).inside(UNARY + 1) == "(-2.0)"
    assert literal_value(2).type == INT


def test_whole_numbers_become_floats():
    assert as_float(Value("3", INT)).text == "3.0"
    assert as_float(Value("n + 1", INT, SUM)).text == "(double)(n + 1)"
    assert as_float(Value("x", FLOAT)).text == "x"


def test_a_pointer_is_followed():
    assert plain(Value("p", FLOAT, pointer=True)).text == "*p"
    assert shown(Array(FLOAT, (2, 3))) == "an array of float, (2, 3)"
