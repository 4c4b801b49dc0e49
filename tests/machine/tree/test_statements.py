"""The text: short lines, brackets where they are needed, names where something is used twice."""

import pytest

from polydraulic.machine.tree.statements import WIDTH, Constants, body, call, returned
from polydraulic.machine.tree.terms import Recorder


@pytest.fixture
def record():
    return Recorder()


def written(*roots, constants=None):
    return body(roots, ", ".join, constants)


def leaves(record, names):
    return [record.leaf(name, name) for name in names]


def test_what_is_used_once_stands_in_place(record):
    x, y, z = leaves(record, "xyz")
    assert written(x * (y + z)) == "    return x * (y + z)"
    assert written(x - (y - z)) == "    return x - y + z"
    assert written(-(x * y)) == "    return -x * y"
    assert written(x * y - 2.0 * (y + z)) == "    return x * y - 2.0 * (y + z)"
    assert written(record.reciprocal(x * y)) == "    return 1.0 / (x * y)"
    assert written(record.reciprocal(x) * y) == "    return y * (1.0 / x)"


def test_what_is_used_twice_is_assigned(record):
    x, y = leaves(record, "xy")
    both = x + y
    assert written(both * both, both) == "    result_part = x + y\n    return result_part * result_part, result_part"
    assert written(x * y, x * y + x).startswith("    x_times_y = x * y\n")


def test_what_has_a_name_is_assigned(record):
    x, y = leaves(record, "xy")
    record.section = "sums"
    assert written((x + y).named("total") * x) == "    total = x + y\n    return x * total"


def test_sections_are_comments_where_functions_run(record):
    x, y = leaves(record, "xy")
    record.section = "sums"
    assert "    # sums\n    total = x + y" in written((x + y).named("total") * x, constants=Constants())


def test_what_is_known_late_is_added_last(record):
    x, y, z = leaves(record, "xyz")
    assert written(x * (y * (x + z)) + y) == "    return y + x * y * (x + z)"


def test_fixed_terms_are_fields(record):
    x, y = leaves(record, "xy")
    a, b = (record.leaf(name, name, fixed=True) for name in "ab")
    constants = Constants()
    text = written((a * b * x + a * (y * y)).named("total"), a + b, constants=constants)
    assert text.splitlines() == [
        "    total = constants.a_times_b * x + constants.a * y * y",
        "    return total, constants.result_fixed",
    ]
    assert [node.name for node in constants.nodes] == ["a_times_b", "a", "result_fixed"]


def test_lines_are_short(record):
    names = [f"a_rather_long_name_{k}" for k in range(12)]
    terms = leaves(record, names)
    total = sum(terms[1:], terms[0]).named("total")
    text = written(total, total * total)
    assert max(map(len, text.splitlines())) <= WIDTH
    assert text.startswith("    total = (\n        a_rather_long_name_0\n        + a_rather_long_name_1\n")
    text = returned(call("Outer", [call("Inner", names), "1.0"]))
    assert text.splitlines()[:3] == ["    return Outer(", "        Inner(", "            a_rather_long_name_0,"]
    assert text.splitlines()[-2:] == ["        1.0,", "    )"]
