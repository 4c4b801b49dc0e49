"""Examples run, are short, and check what they show."""

import ast
import json
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted(ROOT.glob("examples/*.py"))
NOTEBOOKS = sorted(ROOT.glob("examples/*.ipynb"))
WITHOUT_MACHINES = {"c_code", "learn_a_function", "learn_a_table"}  # these are quick in plain Python, too


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, id=p.stem, marks=[] if p.stem in WITHOUT_MACHINES else pytest.mark.slow) for p in SCRIPTS],
)
def test_a_script_runs_and_its_checks_hold(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_runs_and_its_checks_hold(path, tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert any(output["output_type"] == "display_data" or "data" in output for output in _outputs(notebook))


def _outputs(notebook):
    return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda p: p.stem)
def test_a_script_is_short_says_what_it_shows_and_ends_in_a_check(path):
    text = path.read_text()
    tree = ast.parse(text)
    code = [line for line in text.splitlines() if line.strip()]
    assert 10 <= len(code) <= 40
    assert ast.get_docstring(tree)
    assert any(isinstance(node, ast.Assert) for node in ast.walk(tree.body[-1]))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_is_kept_without_outputs_and_has_a_check(path):
    cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in cells)
    assert any("assert " in "".join(cell["source"]) for cell in cells)


def test_the_docs_show_every_example():
    shown = (ROOT / "docs" / "examples.md").read_text()
    for path in [*SCRIPTS, *NOTEBOOKS]:
        assert f"](../examples/{path.name})" in shown, path.name
