import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.export.c.text import FLOAT, block_comment, literal, one_line, string


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


def test_nothing_in_a_comment_ends_it_or_is_a_trigraph():
    text = block_comment(["a */ b", "/* c", "??/", "two\nlines"])
    assert text.splitlines() == ["/*", " * a * / b", " * / * c", " * ? ?/", " * two lines", " */"]
    assert one_line("a\r\n b") == "a b"


def test_strings_hold_any_bytes():
    text = string('a"\\?ö\n')
    assert text == '"a\\042\\134\\077\\303\\266\\012"'
    octal = text[1:-1].encode().decode("unicode_escape").encode("latin-1").decode()
    assert octal == 'a"\\?ö\n'
