"""Documentation that runs, and parameters that are all described."""

import doctest
import importlib
import inspect
import pkgutil
import re
import runpy
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import polydraulic
from polydraulic.cli import main

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
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


QUICK = ("guide", "simulation", "dynamic_models", "export", "export_machine")
PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LANGUAGES = {"python", "sh", "bash", "toml", "c", "text"}  # bash: to install and to build, which `make build` and CI do
# amounts of work that a reader waits for and a test need not: the same commands on less
LESS = {
    "README.md": {"random:42:600": "random:42:20"},
    "docs/flow_models.md": {"--rows 20000": "--rows 4000", "--rows 60000": "--rows 8000"},
    "docs/machine_from_a_log.md": {"random:1:1800": "random:1:600", "random:5:600": "random:5:100"},
}


def _name(page):
    return str(page.relative_to(ROOT))


def _blocks(page):
    text = page.read_text()
    for words, fewer in LESS.get(_name(page), {}).items():
        assert words in text, words
        text = text.replace(words, fewer)
    return BLOCK.findall(text)


RUN = [page for page in PAGES if any(language in ("python", "sh") for language, _ in _blocks(page))]


@pytest.mark.parametrize(
    "page", [pytest.param(p, id=_name(p), marks=[] if p.stem in QUICK else pytest.mark.slow) for p in RUN]
)
def test_python_and_commands_in_the_pages_run(page, tmp_path, monkeypatch, capfd):
    """All blocks of a page one after the other, in an empty folder; what a page says is printed is, up to its numbers."""
    monkeypatch.chdir(tmp_path)
    names, printed = {}, set()
    for language, block in _blocks(page):
        named = re.match(r"(?:#|/\*) (\w+\.(?:toml|c))\b", block)
        if named:  # a file that the reader is to write
            Path(named[1]).write_text(block)
        elif language == "python":
            exec(compile(block, _name(page), "exec"), names)
        elif language == "sh":
            for line in block.replace("\\\n", " ").splitlines():
                _run(line, monkeypatch, fewer=_name(page) == "docs/machine_from_a_log.md")
            printed |= {_without_numbers(said) for said in capfd.readouterr().out.splitlines()}
        elif language == "text" and _name(page) not in LESS:
            for said in block.splitlines():
                assert said.strip() == "..." or _without_numbers(said) in printed, said


def _without_numbers(line):
    """A line with all numbers alike: their last digits may differ between machines."""
    return re.sub(r"-?\d[\d.]*(?:e[+-]\d+)?", "#", " ".join(line.split()))


def _run(line, monkeypatch, *, fewer):
    """Run a command of a page, which says in a comment if its exit code is not to be 0."""
    words = shlex.split(line, comments=True)
    expected = int((re.findall(r"# exit code (\d)", line) or ["0"])[0])
    if words[0] != "polydraulic":
        assert subprocess.run(words, check=False).returncode == expected, line
        return
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit) as stop:
        main()
        sys.exit(0)
    code = stop.value.code or 0
    judged = "check" in words and "--data" in words and fewer  # what less work teaches may hold or not
    assert code in (0, 1) if judged else code == expected, line


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_blocks_of_pages_say_what_they_are(page):
    """Every block is run, is a file that a command reads, or is of a kind that is not for running."""
    for language, block in BLOCK.findall(page.read_text()):
        assert language in LANGUAGES, f"{_name(page)}: {block[:60]}"
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
