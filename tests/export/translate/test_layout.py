from polydraulic.export.translate.layout import WIDTH, wrapped


def test_short_lines_stay():
    assert wrapped("x = a + b;", "    ") == "    x = a + b;"


def test_long_lines_break_where_brackets_are_least_nested_and_lose_nothing():
    inner = ", ".join(f"value_{k}" for k in range(8))
    text = f"const double found = first_function({inner}) + second_function({inner});"
    lines = wrapped(text, "    ").split("\n")
    assert all(len(line) <= WIDTH for line in lines)
    assert lines[1].lstrip().startswith("+ second_function(")
    assert lines[1].startswith(" " * 12)
    assert " ".join(line.strip() for line in lines) == text


def test_what_cannot_be_broken_is_left_long():
    text = "x" * (WIDTH + 20)
    assert wrapped(text, "") == text
