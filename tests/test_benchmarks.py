"""Benchmarks are kept in step with the package that they measure: each can be loaded, with all that it takes from there."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "benchmarks"
NAMES = sorted(path.stem for path in FOLDER.glob("*.py"))


@pytest.mark.parametrize("name", NAMES)
def test_a_benchmark_finds_all_that_it_measures(name, monkeypatch):
    monkeypatch.syspath_prepend(FOLDER)
    assert importlib.import_module(name).__doc__


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if "ArgumentParser" in (FOLDER / f"{name}.py").read_text()])
def test_a_benchmark_says_what_it_does(name):
    done = subprocess.run(
        [sys.executable, FOLDER / f"{name}.py", "--help"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usage: ")
