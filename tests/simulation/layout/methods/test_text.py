"""The text of the methods: readable, the same for all numbers, and without names that mean two things."""

import ast
from collections import Counter

from helpers.small_crane import crane_text
from polydraulic import load_machine
from polydraulic.flow.layout.model import FORGETTING
from polydraulic.parameters.load import machine_names
from polydraulic.simulation.layout.methods.text import methods_text


def test_no_name_is_defined_twice():
    for name in machine_names():
        if name == "cat215b":
            continue
        found = Counter()
        for node in ast.parse(methods_text(load_machine(name))).body:
            if isinstance(node, ast.ImportFrom):
                found.update(alias.name for alias in node.names)
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                found[node.name] += 1
        assert found["run_rosenbrock"] == 1
        assert {name for name, count in found.items() if count > 1} == set()


def test_numbers_are_not_in_the_text(crane, tmp_path):
    path = tmp_path / "heavy.toml"
    path.write_text(crane_text().replace("value = 250,", "value = 251.25,"), encoding="utf-8")
    assert methods_text(load_machine(path)) is methods_text(crane)
    assert "251.25" not in methods_text(crane)


def test_a_force_costs_nothing_where_there_is_none(crane):
    for force in (False, True):
        slopes = methods_text(crane, force=force).partition("def motion_slopes(")[2].partition("@kernel")[0]
        assert ("fx *" in slopes) == force


def test_flow_models_that_keep_nothing_have_runge_kutta_alone(crane):
    for flow in FORGETTING:
        text = methods_text(crane, flow=flow)
        defined = [node.name for node in ast.parse(text).body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        assert len(set(defined)) == len(defined)
        assert "run_runge_kutta" in defined
        assert ("run_rosenbrock" in defined) == (flow == "exact")
        assert ("flow_step(" in text) == (flow != "exact")


def test_lines_are_short(crane):
    assert max(map(len, methods_text(crane).split("\n"))) <= 160
