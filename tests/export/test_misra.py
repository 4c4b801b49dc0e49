"""MISRA C:2012 by cppcheck: advisory findings only, those that the documentation lists."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from polydraulic.export import export_c

# Advisory: macros for the user (2.5), functions and tables of one use (8.7, 8.9), precedence (12.1), several returns (15.5).
LISTED = {"2.5", "8.7", "8.9", "12.1", "15.5"}
BAD = "int f(int a)\n{\n    int unused;\n    if (a) goto end;\n    a = 077;\nend:\n    return a;\n}\n"


def findings(source: Path) -> set[str]:
    folder = str(Path(sys.executable).parent)
    command = shutil.which("cppcheck", path=f"{folder}{os.pathsep}{os.environ['PATH']}")
    assert command, "cppcheck comes with the extra `test`"
    done = subprocess.run(
        [command, "--addon=misra", "--std=c99", "--enable=style", "--suppress=missingIncludeSystem", str(source)],
        capture_output=True, text=True, cwd=source.parent,
    )  # fmt: skip
    return set(re.findall(r"misra-c2012-(\d+\.\d+)", done.stderr))


@pytest.mark.slow
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("which", ["several", "constant"])
def test_only_listed_advisory_rules_are_broken(which, real, exported_models, tmp_path):
    found = findings(export_c(exported_models[which], tmp_path, name="net", real=real).files[1])
    assert "12.1" in found or which == "constant"
    assert found <= LISTED
    page = (Path(__file__).parents[2] / "docs/export.md").read_text()
    assert all(rule in page for rule in LISTED)


@pytest.mark.slow
def test_a_bad_file_is_flagged(tmp_path):
    (tmp_path / "bad.c").write_text(BAD)
    assert findings(tmp_path / "bad.c") - LISTED
