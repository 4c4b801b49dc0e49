"""The public names are typed for whoever uses them: mypy reads a script, as strictly as it can."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_mypy_shows_types_and_mistakes_of_a_script():
    options = ["--config-file=", "--strict", "--follow-imports=silent", "--ignore-missing-imports"]
    cache = f"--cache-dir={ROOT / '.mypy_cache' / 'use'}"  # kept, since a first reading takes long
    script = Path(__file__).parent / "helpers" / "typed_use.py"
    found = subprocess.run(
        [sys.executable, "-m", "mypy", *options, cache, script],
        capture_output=True, text=True, env=os.environ | {"MYPYPATH": str(ROOT / "src")},
    )  # fmt: skip
    assert found.returncode == 0, found.stdout + found.stderr


def test_types_come_with_the_package():
    assert (ROOT / "src" / "polydraulic" / "py.typed").is_file()
