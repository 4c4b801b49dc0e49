import re

import pytest

from polydraulic.errors import InputError
from polydraulic.names import checked_name, checked_text


@pytest.mark.parametrize("name", ["p", "Ünï 🙂", "two\nlines", "a\tb", "p\u00a0[bar]", "\\frac{%", "x" * 10_000])
def test_what_can_be_written_is_a_name(name):
    assert checked_name(name, "column") is name


@pytest.mark.parametrize(
    "sign", ["\x00", "\x07", "\x1b", "\x7f", "\x96", "\u2028", "\u202e", "\u2066", "\ud83d", "\ufdd0", "\uffff"]
)
def test_what_no_file_takes_is_named_with_its_owner(sign):
    with pytest.raises(InputError, match=re.escape(f"column {'p' + sign!r}: holds the character {sign!r}")):
        checked_name("p" + sign, "column")


def test_a_name_is_not_blank_but_a_text_may_be():
    assert checked_text("", "unit") == ""
    with pytest.raises(InputError, match="column '\\\\t ': is blank"):
        checked_name("\t ", "column")
    with pytest.raises(InputError, match="column 3: must be a string"):
        checked_name(3, "column")
