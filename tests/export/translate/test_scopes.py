import ast
import textwrap

from polydraulic.export.translate.scopes import comments_of, find_uses, is_elif

SOURCE = """
def f(x):
    # above
    a = 0.0  # behind
    if x > 1.0:
        b = 1.0
        a = a + b
    elif x > 0.0:
        c = 2.0
    else:
        c = 3.0  # noqa: F841
    for i in range(3):
        d = a
    return c
"""


def body():
    return ast.parse(textwrap.dedent(SOURCE)).body[0].body


def test_a_variable_lives_in_the_innermost_block_that_holds_all_of_it():
    found, statements = find_uses(body()), body()
    assert set(found) == {"a", "b", "c", "i", "d"}
    assert [found[name].times_assigned for name in "abcd"] == [2, 1, 2, 1]
    outer = found["a"].home()[0]
    assert found["a"].home() == (outer, 0)
    assert found["c"].home() == (outer, 1)
    assert found["b"].home()[0] != outer
    assert found["b"].home()[1] == 0
    assert found["d"].home()[0] not in (outer, found["b"].home()[0])
    assert len(statements) == 4


def test_an_elif_is_an_else_with_nothing_but_an_if():
    chosen = body()[1]
    assert is_elif(chosen.orelse)
    assert not is_elif(chosen.orelse[0].orelse)


def test_comments_stand_at_their_lines_without_notes_for_tools():
    assert comments_of(SOURCE.strip("\n"), 10) == {11: "above", 12: "behind"}
