"""The text of a layout: readable, the same for all numbers, and without names that mean two things."""

import ast
from collections import Counter

from helpers.small_crane import crane_text, crane_text_with_effects
from polydraulic import load_machine
from polydraulic.parameters.load import machine_names
from polydraulic.simulation.layout.text import fields_of, layout_of, layout_text


def named(text):
    """Names that the top of a module defines or imports."""
    found = Counter()
    for node in ast.parse(text).body:
        if isinstance(node, ast.ImportFrom):
            found.update({(alias.asname or alias.name, node.module) for alias in node.names})
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name, ""] += 1
        elif isinstance(node, ast.Assign):
            targets = node.targets[0].elts if isinstance(node.targets[0], ast.Tuple) else node.targets
            found.update((target.id, "") for target in targets)
    return found


def layouts():
    return [name for name in machine_names() if name != "cat215b"]


def test_no_name_is_defined_twice():
    for name in layouts():
        found = named(layout_text(load_machine(name)))
        assert max(found.values()) == 1
        twice = {key for key, count in Counter(key for key, _ in found).items() if count > 1}
        assert twice == set(), name


def test_effects_bring_no_second_meaning(tmp_path):
    path = tmp_path / "effects.toml"
    path.write_text(crane_text_with_effects(), encoding="utf-8")
    text = layout_text(load_machine(path))
    found = named(text)
    assert max(found.values()) == 1
    assert {key for key, count in Counter(key for key, _ in found).items() if count > 1} == set()
    assert max(map(len, text.split("\n"))) <= 160


def test_numbers_are_not_in_the_text(crane, tmp_path):
    path = tmp_path / "heavy.toml"
    path.write_text(
        crane_text().replace("value = 250,", "value = 251.25,").replace('"Small crane"', '"Other title"'),
        encoding="utf-8",
    )
    heavy = load_machine(path)
    assert heavy != crane
    assert layout_of(heavy) == layout_of(crane)
    assert layout_text(heavy) is layout_text(crane)
    assert "251.25" not in layout_text(heavy)
    assert "title" not in layout_text(heavy)


def test_what_is_declared_is_part_of_the_layout(crane):
    links = tuple(link._replace(cg={**link.cg, "y": 0.0}) if link.name == "arm" else link for link in crane.links)
    assert layout_of(crane._replace(links=links)) != layout_of(crane)


def test_lines_are_short_and_fields_found(crane):
    text = layout_text(crane)
    assert max(map(len, text.split("\n"))) <= 160
    assert fields_of(text, "Held") == list(crane.names)
    assert "def machine_step(" in text
