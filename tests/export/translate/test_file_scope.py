from typing import NamedTuple

import numpy as np

from polydraulic.export.translate.file_scope import FileScope
from polydraulic.export.translate.types import FLOAT


class Inner(NamedTuple):
    """A part."""

    x: float  # m


class Whole(NamedTuple):
    """All of it."""

    inner: Inner
    rows: np.ndarray
    on: bool


EXAMPLE = Whole(Inner(0.5), np.array([[1.0, 2.0], [3.0, 4.0]]), True)


def test_parts_are_defined_before_wholes_with_their_comments():
    scope = FileScope()
    scope.layouts.of_value(EXAMPLE, "example")
    text = scope.structs()
    assert text.index("} Inner;") < text.index("} Whole;")
    assert "/* A part. */\ntypedef struct {\n    double x; /* m */\n} Inner;" in text
    assert "const double (*rows)[2];" in text


def test_data_are_constants_with_their_arrays_before_them():
    text = FileScope().data(EXAMPLE, "numbers", "static ")
    arrays, struct = text.split("static const Whole")
    assert arrays == "static const double numbers_rows[2][2] = {\n{1.0, 2.0},\n{3.0, 4.0}\n};\n"
    assert struct.split() == "numbers = { .inner = { .x = 0.5, }, .rows = numbers_rows, .on = true, };".split()
    assert ".rows = NULL" in FileScope().data(EXAMPLE._replace(rows=np.zeros((0, 2))), "none")


def test_constants_and_helpers_stand_there_once_and_only_if_asked_for():
    scope = FileScope(["LIMIT"])
    assert scope.constants() == []
    value = scope.constant("LIMIT", 2.5, test_data_are_constants_with_their_arrays_before_them)
    assert (value.type, value.text) == (FLOAT, "TEST_FILE_SCOPE_LIMIT")  # its own name is taken
    assert scope.constant("LIMIT", 2.5, test_data_are_constants_with_their_arrays_before_them) == value
    assert scope.helper("maximum") == scope.helper("maximum") == "maximum"
    declared, helper = scope.constants()
    assert declared == "static const double TEST_FILE_SCOPE_LIMIT = 2.5;\n"
    assert helper.startswith("static inline double maximum(double a, double b)")
