"""What is public: listed on one page, under one path each, with options by name; and no change of it goes unsaid."""

import ast
import importlib
import inspect
import logging
import pydoc
import re
import runpy
from pathlib import Path

import pytest

import polydraulic

ROOT = Path(__file__).parents[1]
TOOL = runpy.run_path(str(ROOT / "tools" / "public_surface.py"))
PACKAGES = {name: importlib.import_module(name) for name in TOOL["PACKAGES"]}
# what a function works on may have a default; all else that has one is an option
WORKED_ON = {"machine", "flow", "estimator", "box", "columns", "duration", "units", "info"}
INSIDE = {"docs/export_machine.md": {"polydraulic.elementary", "polydraulic.export.translate.program"}}  # how it works


def listed(package):
    """Names in the table of a package in docs/api.md, in order."""
    page = (ROOT / "docs" / "api.md").read_text()
    section = re.search(rf"^## {re.escape(package)}\n(.*?)(?=^## )", page, re.DOTALL | re.MULTILINE)
    return re.findall(r"^\| `(\w+)` \| \S.+ \|$", section[1], re.MULTILINE)


def stub(package):
    """Names in the stub of a package."""
    tree = ast.parse(Path(PACKAGES[package].__file__).with_suffix(".pyi").read_text())
    (names,) = [node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "__all__"]
    return ast.literal_eval(names)


@pytest.mark.parametrize("package", PACKAGES)
def test_the_page_lists_what_the_stub_says(package):
    assert sorted(listed(package)) == sorted(stub(package)) == sorted(PACKAGES[package].__all__)


def test_the_page_lists_every_package():
    found = sorted(f"polydraulic.{path.parent.name}" for path in (ROOT / "src" / "polydraulic").glob("*/__init__.pyi"))
    assert ["polydraulic", *found] == sorted(PACKAGES)


def test_a_public_name_has_one_path():
    paths = {}
    for package in PACKAGES:
        for name in stub(package):
            paths.setdefault(name, []).append(package)
    assert {name: found for name, found in paths.items() if len(found) > 1} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_options_are_given_by_name(package):
    for name in PACKAGES[package].__all__:
        thing = getattr(PACKAGES[package], name)
        function = inspect.isfunction(thing) or (inspect.isclass(thing) and hasattr(thing, "fit"))
        for parameter in inspect.signature(thing).parameters.values() if function else ():
            by_place = parameter.kind is parameter.POSITIONAL_OR_KEYWORD
            optional = parameter.default is not parameter.empty and parameter.name not in WORKED_ON
            assert not (by_place and optional), f"{package}.{name}: {parameter.name}"


@pytest.mark.parametrize("package", PACKAGES)
def test_progress_has_one_shape(package):
    for name in PACKAGES[package].__all__:
        thing = getattr(PACKAGES[package], name)
        for parameter in inspect.signature(thing).parameters.values() if inspect.isfunction(thing) else ():
            assert parameter.name != "progress" or parameter.annotation is polydraulic.Progress, name


def test_help_and_completion_show_every_name_with_its_types():
    text = pydoc.render_doc(polydraulic, renderer=pydoc.plaintext)
    assert "simulate(machine: polydraulic.parameters.layout.schema.LayoutMachine | str | pathlib" in text
    for name in polydraulic.__all__:
        assert re.search(rf"\b{name}\b", text), name
        assert name in dir(polydraulic)


def test_pages_and_examples_use_public_names():
    sources = [*ROOT.glob("docs/*.md"), ROOT / "README.md", *ROOT.glob("examples/*")]
    used = 0
    for source in sources:
        place = str(source.relative_to(ROOT))
        for module, names in re.findall(
            r"^\W*from (polydraulic[\w.]*) import ([\w, ]+)", source.read_text(), re.MULTILINE
        ):
            if module in INSIDE.get(place, ()):
                continue
            assert module in PACKAGES, f"{place}: {module}"
            for name in names.split(", "):
                assert hasattr(PACKAGES[module], name.strip()), f"{place}: {module}.{name}"
                used += 1
    assert used > 50


def test_library_messages_go_to_one_logger_and_nowhere_by_themselves():
    assert [type(handler) for handler in logging.getLogger("polydraulic").handlers] == [logging.NullHandler]


def test_the_public_surface_is_as_written():
    written = (ROOT / "docs" / "public_surface.txt").read_text()
    names = TOOL["changed"](written, TOOL["surface"]())
    assert not names, f"the public surface has changed: {names}; say so in a file in changes/, then run `make surface`"


def test_what_has_changed_is_found():
    old = (
        "polydraulic.f(a, *, b=1)\npolydraulic.networks.C.m(self)\npolydraulic.networks.C.x: int\npolydraulic.gone()\n"
    )
    new = "polydraulic.f(a, *, b=2)\npolydraulic.networks.C.m(self)\npolydraulic.networks.C.x: float\npolydraulic.flow.OK: 0\n"
    assert TOOL["changed"](old, old) == []
    names = TOOL["changed"](old, new)
    assert names == ["f", "C.x", "gone", "OK"]
    assert TOOL["unsaid"](names, "`gone` went, f has another default, and so has C; lookup OKAY") == ["OK"]


def test_nothing_is_written_until_a_change_is_said(tmp_path, monkeypatch, capsys):
    (tmp_path / "changes").mkdir()
    file = tmp_path / "surface.txt"
    main = TOOL["main"]
    monkeypatch.setitem(main.__globals__, "ROOT", tmp_path)
    monkeypatch.setitem(main.__globals__, "FILE", file)
    now = TOOL["surface"]()
    before = now.replace("dt: float=0.005", "dt: float=0.01").replace("polydraulic.compare(", "polydraulic.difference(")
    file.write_text(before)
    assert main() == 1
    assert file.read_text() == before
    said = capsys.readouterr().out
    assert "+polydraulic.compare(" in said
    assert re.search(r"no file says what has changed of .*simulate.*compare", said)
    words = " ".join(TOOL["changed"](before, now))
    (tmp_path / "changes" / "+names.changed.md").write_text(f"These have changed: {words}.")
    assert main() == 0
    assert file.read_text() == now
