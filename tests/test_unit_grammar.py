"""What the grammar lets through, whoever wrote the text, and how fast it refuses the rest."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.unit_grammar import DEEPEST, LONGEST, MOST_NAMES, UnknownError, names_of, plain_text, split_mark


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("m", [("m", 1.0)]),
        ("kN·m", [("kN", 1.0), ("m", 1.0)]),
        ("m·s⁻²", [("m", 1.0), ("s", -2.0)]),
        ("l/min/bar", [("l", 1.0), ("min", -1.0), ("bar", -1.0)]),
        ("in³/(s psi^0.5)", [("in", 3.0), ("s", -1.0), ("psi", -0.5)]),
        ("N m/(rad/s)", [("N", 1.0), ("m", 1.0), ("rad", -1.0), ("s", 1.0)]),
        ("1/min", [("min", -1.0)]),
        ("ft-lb", [("ft", 1.0), ("lb", 1.0)]),
        ("s^(-1)", [("s", -1.0)]),
        ("m**2", [("m", 2.0)]),
        ("cu in/sec.", [("in", 3.0), ("sec", -1.0)]),
    ],
)
def test_names_and_powers(text, names):
    assert names_of(plain_text(text)) == names


@pytest.mark.parametrize(
    "text",
    [
        "",
        "/",
        "m/",
        "m//s",
        "*m",
        "m^5",
        "m^-5",
        "m^22",
        "5 m",
        "m(",
        "m)",
        "()",
        "l/min bar",
        "m^^2",
        "m;s",
        "m" + " m" * 8,
    ],
)
def test_what_is_none_of_the_grammar(text):
    with pytest.raises(UnknownError):
        names_of(plain_text(text))


def test_brackets_are_nested_so_deep_only():
    assert names_of("(" * DEEPEST + "m" + ")" * DEEPEST) == [("m", 1.0)]
    with pytest.raises(UnknownError, match="nested too deep"):
        names_of("(" * (DEEPEST + 1) + "m" + ")" * (DEEPEST + 1))


def test_marks_of_pressures():
    assert split_mark(plain_text("bar (abs.)")) == ("bar", "a")
    assert split_mark(plain_text("psi[g]")) == ("psi", "g")
    assert split_mark(plain_text("kgf/cm²d")) == ("kgf/cm2", "g")
    assert split_mark("bar") is None


@given(st.text(alphabet="mbars/()^-.*²³· 1234", max_size=LONGEST))
def test_what_is_let_through_is_bounded(text):
    try:
        names = names_of(plain_text(text))
    except UnknownError:
        names = [("m", 1.0)]
    assert 0 < len(names) <= MOST_NAMES
    assert all(0.5 <= abs(power) <= 4.5 and len(name) <= LONGEST for name, power in names)


@pytest.mark.parametrize(
    "text",
    [
        "m^" * 50_000,
        "(" * 100_000,
        "a/" * 50_000,
        "ﷺ" * LONGEST,
        "x" * 59 + "(",
        " " * 59 + "&",
        "deg " * 15 + "&",
        "_" * 59 + "&",
    ],
)
def test_text_of_any_length_is_answered_at_once(text):
    begin = time.perf_counter()
    with pytest.raises(UnknownError):
        split_mark(plain_text(text))
        names_of(plain_text(text))
    assert time.perf_counter() - begin < 1.0
