"""Tables as plain text."""

from polydraulic.pages.text import text_table


def test_columns_are_as_wide_as_their_longest_text():
    lines = text_table(["output", "rms"], [["q_in", "0.25"], ["pressure.pump", "1"]])
    assert lines == ["  output          rms", "  q_in           0.25", "  pressure.pump     1"]
    assert len({len(line) for line in lines}) == 1
