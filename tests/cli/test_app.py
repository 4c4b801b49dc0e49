"""What the whole command line has in common: version, completion, units, `python -m`."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

import polydraulic
from polydraulic.cli import app
from polydraulic.cli.application import PANELS
from polydraulic.parameters.scenario import scenario_names

COMMANDS = [c.name or c.callback.__name__.replace("_", "-") for c in app.registered_commands]
SOURCES = str(Path(polydraulic.__file__).parents[1])


def complete(words):
    """What bash would offer for the last word."""
    place = len(words.split(" ")) - 1
    asked = {"_POLYDRAULIC_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(place)}
    found = subprocess.run(
        [sys.executable, "-c", "from polydraulic.cli import app; app(prog_name='polydraulic')"],
        env=os.environ | {"PYTHONPATH": SOURCES} | asked, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.stderr == ""
    return found.stdout.split()


def test_the_version(call):
    assert call("--version") == (0, f"polydraulic {polydraulic.__version__}\n", "")


def test_the_package_runs_as_a_module():
    found = subprocess.run(
        [sys.executable, "-m", "polydraulic", "--version"],
        env=os.environ | {"PYTHONPATH": SOURCES}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert found.stdout == f"polydraulic {polydraulic.__version__}\n"


def test_at_its_end_the_program_looks_for_no_garbage():
    """Python looks through all objects twice, which would take as long as numba's import."""
    code = (
        "import atexit, gc, sys\n"
        "atexit.register(lambda: print(gc.get_freeze_count() > 0))\n"
        "from polydraulic.cli import main\n"
        "sys.argv = ['polydraulic', '--version']\n"
        "main()"
    )
    found = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": SOURCES},
        capture_output=True,
        text=True,
        check=True,
    )
    assert found.stdout.splitlines()[1:] == ["True"]


def test_the_help_names_first_steps_and_all_commands(call):
    code, out, _ = call("--help")
    assert code == 0
    assert "polydraulic simulate task --plot task.svg" in re.sub(r"\s+", " ", out)
    assert all(re.search(rf"(?<![\w-]){name}\s", out) for name in [*COMMANDS, "--version", "--install-completion"])


def test_every_command_stands_in_one_panel_of_the_help(call):
    named = [name for names in PANELS.values() for name in names]
    assert sorted(named) == sorted(set(get_command(app).commands))
    _, out, _ = call("--help")
    places = [out.index(text) for panel, names in PANELS.items() for text in (f" {panel} ", f"│ {names[0]} ")]
    assert places == sorted(places)


def test_bash_completes_commands_options_and_values():
    assert complete("polydraulic sim") == ["simulate"]
    assert complete("polydraulic fit-") == ["fit-machine", "fit-joints"]
    assert complete("polydraulic simulate --uni") == ["--units"]
    assert complete("polydraulic simulate task --units ") == ["metric", "field", "si"]
    assert set(complete("polydraulic simulate s")) == {name for name in scenario_names() if name.startswith("s")}
    assert complete("polydraulic simulate task --flow po") == ["polynomial", "polynomial-fine"]


def test_bash_takes_the_script(tmp_path):
    """The script that `--show-completion` prints, in a bash of its own: it offers what the command line answers."""
    program = tmp_path / "polydraulic"
    program.write_text(f"#!{sys.executable}\nfrom polydraulic.cli import app\napp(prog_name='polydraulic')\n")
    program.chmod(0o755)
    script = """
source <(_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION=1 polydraulic --show-completion bash)
complete -p polydraulic
COMP_WORDS=(polydraulic anim); COMP_CWORD=1
_polydraulic_completion polydraulic
echo "offered: ${COMPREPLY[@]}"
"""
    found = subprocess.run(
        ["bash", "-c", script],
        env=os.environ | {"PYTHONPATH": SOURCES, "PATH": f"{tmp_path}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "-F _polydraulic_completion" in found.stdout, found.stderr
    assert "offered: animate" in found.stdout, found.stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_every_help_has_an_example_and_what_comes_next(call, command):
    code, out, _ = call(command, "--help")
    text = re.sub(r"[\s│]+", " ", out)
    assert code == 0
    assert f"Example: polydraulic {command}" in text
    assert "What comes next:" in text


@pytest.mark.parametrize(
    "line",
    ["simulate task", "animate task --out a.html", "fit t.csv --inputs a --outputs b --out m.json", "check m.json",
     "run m.json log.csv", "import log.csv", "fit-machine t.csv --out m.json", "replay t.csv"],
)  # fmt: skip
def test_another_system_of_units_is_refused_before_any_work(call, line):
    code, out, err = call(f"{line} --units imperial")
    assert (code, out) == (2, "")
    assert err == "error: units = 'imperial': choose one of ['metric', 'field', 'si']\n"
