"""Pages of the documentation, run as a reader would: block after block, in an empty folder."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from polydraulic.cli import main

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# amounts of work that a reader waits for and a test need not: the same commands on less
LESS = {
    "README.md": {"random:42:600": "random:42:20"},
    "docs/guide.md": {"tolerance=0.5": "tolerance=4.0, rows=300"},
    "docs/flow_models.md": {"--rows 20000": "--rows 4000", "--rows 60000": "--rows 8000"},
    "docs/measured_logs.md": {":120": ":40", "--regions 6 --layers 3": "--regions 2 --layers 2"},
    "docs/machine_from_a_log.md": {"random:1:1800": "random:1:600", "random:5:600": "random:5:100"},
}


def name_of(page):
    return str(page.relative_to(ROOT))


def blocks_of(page):
    text = page.read_text()
    for words, fewer in LESS.get(name_of(page), {}).items():
        assert words in text, words
        text = text.replace(words, fewer)
    return BLOCK.findall(text)


def run_page(page, monkeypatch, capfd):
    """Run all blocks; what a page says is printed is, up to its numbers. Returns all that was."""
    names, printed, output = {}, set(), ""
    for language, block in blocks_of(page):
        named = re.match(r"(?:#|/\*) (\w+\.(?:toml|c))\b", block)
        if named:  # a file that the reader is to write
            Path(named[1]).write_text(block)
        elif language == "python":
            exec(compile(block, name_of(page), "exec"), names)
        elif language == "sh":
            for line in block.replace("\\\n", " ").splitlines():
                _run(line, monkeypatch, fewer=name_of(page) in LESS)
        elif language == "text" and name_of(page) not in LESS:
            for said in block.splitlines():
                assert said.strip() == "..." or _without_numbers(said) in printed, said
        said = capfd.readouterr().out
        output += said
        printed |= {_without_numbers(line) for line in said.splitlines()}
    return output


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
