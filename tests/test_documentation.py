"""Documentation that runs, and parameters that are all described."""

import doctest
import importlib
import inspect
import pkgutil
import re
import shlex
import sys
from pathlib import Path

import pytest

import polydraulic
from polydraulic.cli import main

ROOT = Path(__file__).parents[1]
MODULES = [m.name for m in pkgutil.walk_packages(polydraulic.__path__, "polydraulic.")]
PACKAGES = ["networks", "flow", "export", "measure", "plotting"]


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings_run(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


@pytest.mark.parametrize("package", PACKAGES)
def test_every_parameter_is_described(package):
    module = importlib.import_module(f"polydraulic.{package}")
    for name in module.__all__:
        thing = getattr(module, name)
        assert inspect.getdoc(thing) or not callable(thing), name
        if inspect.isfunction(inspect.unwrap(thing)):
            text = inspect.getdoc(thing)
            parameters = [p for p in inspect.signature(thing).parameters if p not in ("self", "args", "kwargs")]
            missing = [p for p in parameters if not re.search(rf"\b{p}\b", text)]
            assert not missing, f"{package}.{name}: {missing}"


PAGES = ["README.md", *(f"docs/{name}.md" for name in "guide simulation dynamic_models export export_machine".split())]


@pytest.mark.parametrize("page", PAGES)
def test_python_and_commands_in_the_pages_run(page, tmp_path, monkeypatch):
    blocks = re.findall(r"```(python|sh)\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert blocks
    monkeypatch.chdir(tmp_path)
    names = {}
    for language, block in blocks:
        if language == "python":
            exec(compile(block, page, "exec"), names)
            continue
        for line in block.splitlines():
            monkeypatch.setattr(sys, "argv", shlex.split(line))
            with pytest.raises(SystemExit) as stop:
                main()
                sys.exit(0)
            assert not stop.value.code, line


def test_commands_in_the_readme_exist():
    text = (ROOT / "README.md").read_text()
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"^make (\S+)", text, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_files_named_in_the_documentation_exist():
    for page in [*ROOT.glob("docs/*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        for name in re.findall(r"`((?:src|tests|docs|benchmarks)/[\w/.-]+)`", page.read_text()):
            assert (ROOT / name).exists(), f"{page.name} names {name}"
