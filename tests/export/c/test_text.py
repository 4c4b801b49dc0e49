from textwrap import fill

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.errors import InputError
from polydraulic.export.c.text import FLOAT, block_comment, inner_ends, listed, literal, one_line, rounded_down, string


@pytest.mark.parametrize("value", [0.1, 1e300, -2.5, 5.0, 1e-320, 123456789.0])
def test_a_literal_reads_back_exactly(value):
    text = literal(value)
    assert float(text.strip("()")) == value
    assert any(mark in text for mark in ".e")  # never a whole number, which C divides otherwise
    assert text.startswith("(") == (value < 0.0)


def test_floats_have_their_suffix_and_their_limits():
    assert literal(0.1, FLOAT) == "0.1f"
    assert np.float32(literal(np.pi, FLOAT).rstrip("f")) == np.float32(np.pi)
    for value in (1e39, 1e-42):
        with pytest.raises(InputError, match="does not fit into a float"):
            literal(value, FLOAT)


@pytest.mark.parametrize("n", [1, 2, 9, 40])
def test_lists_are_filled_as_prose_is(n):
    texts = [str(10**k) for k in np.random.default_rng(n).integers(0, 12, n)]
    assert listed(texts, 30) == fill(", ".join(texts), 30, initial_indent="    ", subsequent_indent="    ")


def test_nothing_in_a_comment_ends_it_or_is_a_trigraph():
    text = block_comment(["a */ b", "/* c", "??/", "two\nlines"])
    assert text.splitlines() == ["/*", " * a * / b", " * / * c", " * ? ?/", " * two lines", " */"]
    assert one_line("a\r\n b") == "a b"


def test_strings_hold_any_bytes():
    text = string('a"\\?ö\n')
    assert text == '"a\\042\\134\\077\\303\\266\\012"'
    octal = text[1:-1].encode().decode("unicode_escape").encode("latin-1").decode()
    assert octal == 'a"\\?ö\n'


@given(st.floats(-1e30, 1e30), st.floats(0.0, 1e-6))
def test_a_float_lies_between_the_ends_exactly_if_it_lies_in_the_range(low, width):
    high = low + width * abs(low)
    ends = inner_ends(low, high, FLOAT)
    near = [np.float32(low), np.float32(high)]
    near += [np.nextafter(value, np.float32(to)) for value in near for to in (-np.inf, np.inf)]
    inside = [float(value) for value in near if low <= float(value) <= high]
    if inside:
        assert [value for value in map(float, near) if ends[0] <= value <= ends[1]] == inside
        assert all(float(np.float32(end)) == end for end in ends)
    else:
        assert ends[0] == ends[1] == float(np.float32(0.5 * low + 0.5 * high))
    for value in near:
        assert (float(value) > low) == (float(value) > rounded_down(low, FLOAT))
    assert inner_ends(low, high) == (low, high)
    assert inner_ends(0.0, np.finfo(np.float64).max, FLOAT) == (0.0, float(np.finfo(np.float32).max))
