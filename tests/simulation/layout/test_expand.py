"""Pages are written out for what a layout has."""

import pytest

from polydraulic.simulation.layout.expand import WIDTH, expanded

FUNCTIONS = {
    "FUNCTIONS": [{"F": "boom", "N": 0}, {"F": "stick", "N": 1}],
    "OF_boom": [{"I": "1"}, {"I": "2"}],
    "OF_stick": [],
}


def test_arguments_statements_fields_and_conditions_are_written_out():
    page = '''
class Values(NamedTuple):
    """One a function."""
    for F in FUNCTIONS:
        F: float

def total(x, row):
    for F, N in FUNCTIONS:
        k_F = x.F + row[N]
    if any([x.F > 0.0 for F in FUNCTIONS]) and all([x.F < 9.0 for F in FUNCTIONS]):
        return Values(*[k_F for F in FUNCTIONS])
    for k in range(3):
        row[k] = 0.0
'''
    assert (
        expanded(page, FUNCTIONS)
        == '''class Values(NamedTuple):
    """One a function."""
    boom: float
    stick: float


def total(x, row):
    k_boom = x.boom + row[0]
    k_stick = x.stick + row[1]
    if (x.boom > 0.0 or x.stick > 0.0) and (x.boom < 9.0 and x.stick < 9.0):
        return Values(k_boom, k_stick)
    for k in range(3):
        row[k] = 0.0
'''
    )


def test_loops_may_be_nested_and_definitions_repeated():
    page = "for F in FUNCTIONS:\n    def go_F(x):\n        return g(*[x.F_I for I in OF_F])\n"
    assert (
        expanded(page, FUNCTIONS)
        == "def go_boom(x):\n    return g(x.boom_1, x.boom_2)\n\n\ndef go_stick(x):\n    return g()\n"
    )


def test_a_name_is_replaced_once_even_if_it_looks_like_a_letter():
    page = "def f(x):\n    return g(*[x.F for F in LIST])\n"
    assert expanded(page, {"LIST": [{"F": "N"}, {"F": "F"}]}) == "def f(x):\n    return g(x.N, x.F)\n"


def test_calls_that_are_too_long_are_broken_into_arguments():
    rows = [{"F": f"function_{k}"} for k in range(12)]
    text = expanded("def f(x):\n    return g(*[h(x.F, 1.0) for F in LIST])\n", {"LIST": rows})
    assert "        h(x.function_3, 1.0),\n" in text
    assert max(map(len, text.split("\n"))) <= WIDTH
    compile(text, "page", "exec")


def test_definitions_and_conditions_that_are_too_long_are_broken_into_parts():
    rows = [{"F": f"function_{k}"} for k in range(12)]
    page = """def f(a_long_argument: float, another_long_argument: float, x: object, one_more_argument: float, the_last_one: float) -> float:
    y = any([h(x.F, 1.0) or x.F < 0.0 for F in LIST])
    if all([x.F > 0.0 for F in LIST]):
        return 1.0
    return g(y) if y else 0.0
"""
    text = expanded(page, {"LIST": rows})
    assert "    x: object,\n" in text
    assert "\n) -> float:\n" in text
    assert "        or (h(x.function_3, 1.0) or x.function_3 < 0.0)\n" in text
    assert "        and (x.function_3 > 0.0)\n" in text
    assert max(map(len, text.split("\n"))) <= WIDTH
    found = {}
    exec(compile(text, "page", "exec"), {"h": lambda a, b: a > b, "g": float}, found)
    signs = type("Signs", (), {f"function_{k}": 0.5 for k in range(12)})()
    assert found["f"](0.0, 0.0, signs, 0.0, 0.0) == 1.0
    signs.function_7 = 0.0
    assert found["f"](0.0, 0.0, signs, 0.0, 0.0) == 0.0
    signs.function_7 = -1.0
    found["f"].__globals__["g"] = lambda y: 7.0 * y
    assert found["f"](0.0, 0.0, signs, 0.0, 0.0) == 7.0


def test_what_nobody_gives_is_an_error():
    with pytest.raises(ValueError, match="loops over CIRCUITS"):
        expanded("for C in CIRCUITS:\n    x_C = 1\n", FUNCTIONS)
    with pytest.raises(ValueError, match="the page wants"):
        expanded("for F, Q in FUNCTIONS:\n    x_F = Q\n", FUNCTIONS)
