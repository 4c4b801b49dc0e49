"""Documentation that runs, and parameters that are all described."""

import doctest
import importlib
import inspect
import pkgutil
import re
import runpy
import tomllib

import pytest

import polydraulic
from helpers.pages import BLOCK, ROOT, blocks_of, name_of, run_page

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
MODULES = [m.name for m in pkgutil.walk_packages(polydraulic.__path__, "polydraulic.")]
PACKAGES = ["networks", "flow", "control", "export", "measure", "plotting", "gym"]


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


ELSEWHERE = ("measured_logs", "machine_from_a_log")  # run where what comes out of them is looked at
QUICK = ("guide", "simulation", "dynamic_models", "export", "export_machine")
PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/*.md"))]
LANGUAGES = {"python", "sh", "bash", "toml", "c", "text"}  # bash: to install and to build, which `make build` and CI do
RUN = [
    page
    for page in PAGES
    if any(language in ("python", "sh") for language, _ in blocks_of(page)) and page.stem not in ELSEWHERE
]


@pytest.mark.parametrize(
    "page", [pytest.param(p, id=name_of(p), marks=[] if p.stem in QUICK else pytest.mark.slow) for p in RUN]
)
def test_python_and_commands_in_the_pages_run(page, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    run_page(page, monkeypatch, capfd)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_blocks_of_pages_say_what_they_are(page):
    """Every block is run, is a file that a command reads, or is of a kind that is not for running."""
    for language, block in BLOCK.findall(page.read_text()):
        assert language in LANGUAGES, f"{name_of(page)}: {block[:60]}"
        assert language == "sh" or not re.search(r"^(polydraulic|gcc) ", block, re.MULTILINE), block[:60]
        for extra in re.findall(r"polydraulic\[([\w,]+)\]", block):
            assert set(extra.split(",")) <= set(PROJECT["optional-dependencies"])


def test_the_site_shows_every_page():
    """A page in no list of `docs/conf.py` would go below background, where nobody looks for it."""
    conf = runpy.run_path(str(ROOT / "docs" / "conf.py"))
    linked = "".join(page.read_text() for page in ROOT.glob("docs/*.md"))
    for page in ROOT.glob("docs/*.md"):
        assert page.stem == "index" or f"({page.name}" in linked, page.name
    named = [name for pages in conf["NAVIGATION"].values() for name in pages]
    assert sorted(named) == sorted({page.stem for page in ROOT.glob("docs/*.md")} - {"index"})


def test_commands_of_make_in_the_pages_exist():
    text = "".join(page.read_text() for page in [*PAGES, ROOT / "CONTRIBUTING.md"])
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"(?:^|`)make ([\w-]+)", text, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_files_named_in_the_documentation_exist():
    for page in [*ROOT.glob("docs/*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        for name in re.findall(r"`((?:src|tests|docs|benchmarks|examples|tools|changes)/[\w/.-]+)`", page.read_text()):
            assert (ROOT / name).exists(), f"{page.name} names {name}"
