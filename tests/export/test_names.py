"""Names that mean something elsewhere, through everything that is exported: it compiles, parses and runs, or is refused by name."""

import json
import keyword
import re
import shutil
import subprocess
import sys

import fmpy
import numpy as np
import pytest
from fmpy import validation
from hypothesis import given
from hypothesis import strategies as st

from helpers.in_turn import in_turn
from polydraulic.errors import InputError
from polydraulic.export import bundle, c_name, export_c, export_fmu, export_models, export_onnx, fresh
from polydraulic.export.formula import to_latex
from polydraulic.export.names import unique_names
from polydraulic.networks import Model, Network, Node, Variable

C_WORDS = "int register inline restrict main exp gamma y0 y1 j0 index time read I NULL NAN EOF errno unix signal sinf32".split()
CPP_WORDS = "class template new map list vector function char8_t and not_eq this".split()
PYTHON_WORDS = "lambda None True print len float hasattr sum min match type __debug__ json random numpy".split()
SYMPY_WORDS = "S N E pi beta Symbol Add Float zeta oo distribute Piecewise".split()
OUR_WORDS = (
    "x y z k v r0 slopes zero bad near outside memory partials clamp sigmoid ramp not_a_number value_0_0 value_0_0_slopes region_0 near_y "
    "test_x own own_x fmu FMU fmu_v fmu_state fmi2 fmi3DoStep instance failed done none enter config equations math CON m_ inputs"
).split()
ODD = [
    "a" * 300,
    "Ünï🙂",
    "3d",
    "_x",
    "p / bar",
    "a.b",
    "a-b",
    '"',
    "\\",
    "*/",
    "/*",
    "??/",
    "%",
    "$x",
    "p_{",
    r"\frac",
    "#",
    "'''",
    "{}",
    "&<>",
    "A",
    "a",
]
NAMES = sorted({*C_WORDS, *CPP_WORDS, *PYTHON_WORDS, *SYMPY_WORDS, *OUR_WORDS, *ODD})
HEADERS = (
    "assert complex ctype errno fenv float inttypes limits locale math setjmp signal stdarg stdbool stddef stdint stdio stdlib string "
    "time wchar wctype unistd strings"
).split()
X = np.linspace(-1.0, 1.0, 7)[:, None]


def model(output, x="u", y=0.0):
    """2 + y + 3 x^3, a sigmoid and a ramp of it: all that a network can call."""
    nodes = (Node(0, (0,), (2.0 + y, 0.0, 0.0, 3.0)), Node(4, (1,), (0.0, 1.0)), Node(5, (2,), (-0.5, 2.0)))
    network = Network(nodes, (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0, -5.0, 5.0)
    return Model((Variable(x),), Variable(output), (network,))


ALL = [model(name, y=0.01 * k) for k, name in enumerate(NAMES)]


@pytest.mark.parametrize(
    ("name", "expected"),
    [("boom.q_in", "boom_q_in"), ("int", "int_"), ("3d", "m_3d"), ("Öl", "m__l"), ("_x", "m__x"), ("exp", "exp_"),
     ("value_0_0", "m_value_0_0"), ("class", "class_"), ("", "m_")],
)  # fmt: skip
def test_c_names(name, expected):
    assert c_name(name) == expected


def test_names_that_are_kept_and_names_that_change():
    assert [c_name(name) for name in ("q_in", "y", "high_pressure", "test_flow", "S", "step")] == [
        "q_in", "y", "high_pressure", "test_flow", "S", "step",
    ]  # fmt: skip
    assert [c_name(name) for name in ("None", "sinf32", "Time", "CON", "FMU_N", "own")] == [
        "None_", "sinf32_", "Time_", "CON_", "m_FMU_N", "m_own",
    ]  # fmt: skip
    assert c_name("b" * 300) == "b" * 54 + "_" + c_name("b" * 300)[-8:] != c_name("b" * 299)


@given(st.text() | st.sampled_from(NAMES))
def test_every_name_becomes_a_short_identifier_that_stays_as_it_is(name):
    found = c_name(name)
    assert re.fullmatch(r"[A-Za-z]\w{0,62}", found, re.ASCII)
    assert not keyword.iskeyword(found)
    assert c_name(found) == found


@given(
    st.lists(st.sampled_from(["a b", "a.b", "a_b", "A_b", "a_b_2", "value 0", "value_0", "int", "int_"]), max_size=9)
)
def test_names_that_would_be_one_are_numbered_whatever_their_case(names):
    found = unique_names(names)
    assert len({name.upper() for name in found}) == len(names)
    assert all(c_name(name) == name for name in found)


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_nothing_that_the_headers_of_this_machine_hold_is_in_the_way(tmp_path):
    includes = "".join(f"#include <{name}.h>\n" for name in HEADERS)
    for command, head, ending in (
        (["gcc", "-std=c99"], includes, ".c"),
        (["gcc", "-std=gnu11"], includes, ".c"),
        (
            ["g++", "-std=c++17"],
            "#include <bits/stdc++.h>\nusing namespace std;\n",
            ".cpp",
        ),  # or calls another function
    ):
        file = tmp_path / f"head{ending}"
        file.write_text(head)
        text = subprocess.run([*command, "-E", "-P", file], capture_output=True, text=True, check=True).stdout
        text += subprocess.run([*command, "-dM", "-E", file], capture_output=True, text=True, check=True).stdout
        words = sorted(set(re.findall(r"\b[A-Za-z]\w*", text)))
        assert len(words) > 1000
        names = unique_names(words)
        linkage = 'extern "C" ' if ending == ".cpp" else ""
        lines = ["struct own_ { int status; };"]
        lines += [f"{linkage}struct own_ {name}(const double a_[2], double b_[1]);" for name in names]
        lines += [f"struct own_ call_{k}_(double *a_) {{ return {name}(a_, a_); }}" for k, name in enumerate(names)]
        file.write_text(head + "\n".join(lines) + "\n")
        done = subprocess.run([*command, "-fsyntax-only", "-w", file], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[:2000]


@pytest.mark.parametrize("name", [*OUR_WORDS, *ODD, "index", "char8_t", "len"], ids=lambda name: c_name(name)[:20])
def test_c_of_any_name_compiles_without_warnings_and_passes_its_own_test(name, tmp_path):
    source = export_c([model(name, x=name + "_")], tmp_path).files[1]
    flags = ["-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-I.", f"-D{source.stem.upper()}_SELF_TEST"]
    subprocess.run(["gcc", *flags, source.name, "-o", "own_t", "-lm"], cwd=tmp_path, check=True)
    assert subprocess.run(["./own_t"], cwd=tmp_path).returncode == 0


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_headers_of_all_names_are_included_in_cpp_beside_its_library(tmp_path):
    lines = [f"#include <{header}>" for header in ("map", "vector", "string", "cmath", "ctime", "algorithm", "complex")]
    calls = []
    for name in sorted({name.upper(): name for name in NAMES if name != "value_0_0_slopes"}.values()):
        header, source = export_c([model(name)], tmp_path)
        lines.append(f'#include "{header.name}"')
        calls.append(f"    status |= {source.stem}(own_x, own_y);")
    program = [
        "using namespace std;",
        "int main() {",
        "    double own_x[1] = {0.0}, own_y[1];",
        "    int status = 0;",
        *calls,
    ]
    (tmp_path / "own_u.cpp").write_text("\n".join([*lines, *program, "    return status;", "}", ""]))
    subprocess.run(["g++", "-Wall", "-Werror", "-I.", "-fsyntax-only", "own_u.cpp"], cwd=tmp_path, check=True)


def test_python_functions_of_all_names_stand_in_one_module_and_run_in_a_new_interpreter(tmp_path):
    whole = bundle(ALL, name="random")
    assert np.array_equal(fresh.run_python(whole, tmp_path, X).y, whole.predict(X))


def test_sympy_expressions_of_all_names_stand_in_one_module_and_run_in_a_new_interpreter(tmp_path):
    whole = bundle(ALL)
    written = export_models(ALL, "sympy", tmp_path, name="numbers").main
    names = whole.identifiers()[1]
    program = (
        f"import json, sys; import {written.stem} as m; from math import exp\n"
        f"print(json.dumps([float(getattr(m, name).subs('u', 0.5)) for name in {names!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == pytest.approx(whole.predict(np.array([[0.5]]))[0], rel=1e-12)


@pytest.mark.parametrize("version", [2, 3])
def test_fmus_have_all_names_as_they_are(version, tmp_path):
    inputs = [name + " in" for name in NAMES]
    network = Network(
        (), (0.0,) * len(inputs), (1.0,) * len(inputs), (0.0,) * len(inputs), (1.0,) * len(inputs), 1.5, 1.0
    )
    models = [Model(tuple(map(Variable, inputs)), Variable(name), (network,)) for name in NAMES]
    path = str(export_fmu(models, tmp_path / "odd.fmu", version=version, compiler="").main)
    assert validation.validate_fmu(path) == []
    names = [variable.name for variable in fmpy.read_model_description(path).modelVariables]
    assert names[: 2 * len(NAMES)] == [*inputs, *NAMES]


@pytest.mark.parametrize(
    ("name", "version"),
    in_turn("v memory y fmu config equations instance failed fmi2 main write S".split(), [2, 3]),
)
def test_fmus_of_names_that_their_sources_use_compile_and_answer(name, version, tmp_path):
    whole = bundle([model(name)])
    answers = fresh.run_fmu(whole, tmp_path, version, "CoSimulation", X)
    assert np.array_equal(answers.y, whole.predict(X))


def test_onnx_takes_all_names(tmp_path):
    onnxruntime = pytest.importorskip("onnxruntime")
    whole = bundle(ALL, name="map")
    session = onnxruntime.InferenceSession(str(export_onnx(ALL, tmp_path / "m.onnx", name="map").main))
    assert session.run(["y"], {"x": X})[0] == pytest.approx(whole.predict(X), rel=1e-12)
    told = json.loads(session.get_modelmeta().custom_metadata_map["outputs"])
    assert [output["name"] for output in told] == NAMES


@pytest.mark.parametrize("name", NAMES, ids=lambda name: c_name(name)[:20])
def test_latex_leaves_no_sign_of_a_name_that_tex_would_read(name):
    text = to_latex(model(name, x=name + "_"))
    bare = re.sub(r"\\[\\{}%$#&_]", "", text)
    assert bare.count("{") == bare.count("}")
    assert not re.search(r"[%$#]", bare)
    commands = set(re.findall(r"\\[A-Za-z]+", text))
    assert commands <= set(
        r"\begin \end \frac \text \mathrm \hat \widehat \in \quad \times \exp \min \max \textbackslash \textasciitilde \zeta".split()
    )


@pytest.mark.parametrize("name", ["", " ", "a\x00b", "\x1b[31m", "\uffff", "\ud800", "a\u202eb", "\x7f", "a\u2028"])
def test_names_that_no_file_takes_are_refused_by_name(name):
    for names in ((name, "u"), ("y", name)):
        with pytest.raises(InputError, match=re.escape(f"variable {name!r}")):
            model(*names)
    if name.strip():
        with pytest.raises(InputError, match="unit of 'q', "):
            Variable("q", name)


def test_a_path_that_is_too_long_says_so(tmp_path):
    with pytest.raises(InputError, match="File name too long; choose shorter names"):
        export_models([model("q")], "python", tmp_path / ("a" * 300 + ".py"))
    assert list(tmp_path.iterdir()) == []
