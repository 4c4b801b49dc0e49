"""Every target by its name."""

import shutil

import numpy as np
import pytest

from helpers.exports import NAMES
from polydraulic.errors import InputError
from polydraulic.export import TARGETS, build, bundle, export_models


@pytest.mark.parametrize("to", [to for to in TARGETS if to not in ("c", "onnx")])
def test_every_target_writes_one_file_into_a_folder_or_to_a_path(to, exported_models, tmp_path):
    models = exported_models["several"]
    first = export_models(models, to, tmp_path, name="mine")
    assert [path.stem for path in first.files] == ["mine"]
    second = export_models(models, to, tmp_path / f"other{first.main.suffix}")
    assert second.files == (tmp_path / f"other{first.main.suffix}",)
    assert sorted(tmp_path.iterdir()) == sorted([*first, *second])


def test_c_is_a_folder_and_names_that_change_are_told(exported_models, tmp_path):
    made = export_models(exported_models["several"], "c", tmp_path, name="3 valves")
    assert [path.name for path in made] == ["m_3_valves.h", "m_3_valves.c"]
    assert made.notes == ("names: out put is out_put",)


@pytest.mark.parametrize("which", NAMES)
def test_python_has_a_function_an_output(which, exported_models, tmp_path):
    models, whole = exported_models[which], bundle(exported_models[which])
    names = {}
    exec(export_models(models, "python", tmp_path / "f.py").main.read_text(), names)
    X = whole.points(60)
    functions = zip(models, whole.places, whole.identifiers()[1], strict=True)
    y = [[names[name](*row) for row in X[:, list(place)].tolist()] for _, place, name in functions]
    assert np.array_equal(np.transpose(y), whole.predict(X))


def test_sympy_module_builds_the_expressions(exported_models, tmp_path):
    sympy = pytest.importorskip("sympy")
    whole = bundle(exported_models["several"])
    names = {}
    exec(export_models(whole.models, "sympy", tmp_path / "f.py").main.read_text(), names)
    X = whole.points(60)[:40]
    X = X[whole.outside(X) == 0.0]
    function = sympy.lambdify(sympy.symbols("a b c"), names["mlp"], "numpy")
    order = [[v.name for v in whole.inputs].index(name) for name in "abc"]
    assert function(*X[:, order].T) == pytest.approx(whole.predict(X)[:, 2], rel=1e-12)


def test_without_a_compiler_the_fmu_holds_sources_and_that_is_told(exported_models, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    made = export_models(exported_models["constant"], "fmi3", tmp_path / "x.fmu")
    assert "no C compiler (cc, gcc, clang) is installed: the FMU holds sources only" in made.notes[0]


def test_bad_input(exported_models, tmp_path):
    with pytest.raises(InputError, match=r"unknown target 'mex'; choose one of \['c', 'fmi2'"):
        export_models(exported_models["single"], "mex", tmp_path)
    with pytest.raises(InputError, match="goes with the targets c and onnx"):
        export_models(exported_models["single"], "fmi2", tmp_path, real="float")
    with pytest.raises(InputError, match="other platforms go with the targets fmi2 and fmi3"):
        export_models(exported_models["single"], "c", tmp_path, cross=True)
    for to, out, message in (("c", "q.c", "c writes two files; give a folder$"), ("fmi3", "q.zip", "ends in .fmu")):
        with pytest.raises(InputError, match=message):
            export_models(exported_models["single"], to, tmp_path / out)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        export_models(exported_models["single"], "python", tmp_path / "file" / "f.py")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
