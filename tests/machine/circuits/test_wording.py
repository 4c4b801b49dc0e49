import ast

from polydraulic.machine.circuits.wording import definitions, each, repeated, valves


def test_patterns_are_written_once_for_each_number():
    assert each("x.w_~", 1, 3) == "x.w_1, x.w_2, x.w_3"
    assert repeated("    q_~ = w_~- - w_~ + w_~+", [3, 2]) == "    q_3 = w_2 - w_3 + w_4\n    q_2 = w_1 - w_2 + w_3"
    assert valves(2) == "k_1, k_2, p_1, p_2, pump"


def test_long_calls_are_broken_and_mean_the_same():
    call = f"    total = solved({each('first_argument_~', 1, 30)})"
    text = definitions(["def f():\n    pass\n", f"def g():\n{call}"])
    assert max(map(len, text.splitlines())) <= 120
    assert ast.unparse(ast.parse(text)) == ast.unparse(ast.parse(f"def f():\n    pass\ndef g():\n{call}"))
    assert "\n\n\ndef g" in text
