"""FMUs of models in other people's importers: FMPy simulates, CasADi differentiates."""

import re
import shutil
import subprocess
import zipfile

import casadi
import fmpy
import numpy as np
import pytest
from fmpy import validation
from fmpy.build import build_platform_binary

from helpers.exports import NAMES
from helpers.in_turn import in_turn
from polydraulic.errors import InputError
from polydraulic.export import build, bundle
from polydraulic.export.fmu.networks import export_fmu
from polydraulic.networks import Model, Variable

TYPES = ("ModelExchange", "CoSimulation")


@pytest.fixture(scope="module")
def made(exported_models, tmp_path_factory):
    """The FMU of some models in some version: its path, what it is made of, its folder."""
    found = {}

    def make(which, version):
        if (which, version) not in found:
            folder = tmp_path_factory.mktemp("fmu")
            path = export_fmu(exported_models[which], folder / f"f{version}.fmu", version=version).main
            fmpy.extract(str(path), unzipdir=str(folder / "in"))
            found[which, version] = path, bundle(exported_models[which]), folder / "in"
        return found[which, version]

    return make


def instance(made, which, version, kind="CoSimulation", name="one"):
    path, _, folder = made(which, version)
    description = fmpy.read_model_description(str(path))
    found = fmpy.instantiate_fmu(str(folder), description, fmi_type=kind)
    if version == 2:
        found.setupExperiment(startTime=0.0)
    found.enterInitializationMode()
    found.exitInitializationMode()
    return found


def outputs(fmu, whole, x, version):
    n, m = len(whole.inputs), len(whole.models) + 1
    setter, getter = (fmu.setReal, fmu.getReal) if version == 2 else (fmu.setFloat64, fmu.getFloat64)
    setter(list(range(n)), list(x))
    return getter(list(range(n, n + m)))


def reference(folder, whole, version):
    place = folder / ("documentation" if version == 2 else "extra/org.polydraulic")
    stem = "reference" if version == 2 else whole.name
    return tuple(
        np.genfromtxt(place / f"{stem}_{end}.csv", delimiter=",", names=True, deletechars="", replace_space=" ")
        for end in ("in", "ref")
    )


@pytest.mark.parametrize(("which", "version"), in_turn(NAMES, [2, 3]))
def test_fmpy_finds_no_fault_and_simulates_the_reference_results(which, version, made):
    path, whole, folder = made(which, version)
    assert validation.validate_fmu(str(path)) == []
    inputs, expected = reference(folder, whole, version)
    X = np.array(inputs.tolist())[:, 1:]
    assert np.array_equal(np.array(expected.tolist())[:, 1:-1], whole.predict(X))
    for kind in TYPES:
        found = fmpy.simulate_fmu(str(folder), fmi_type=kind, input=inputs, output_interval=0.01, stop_time=1.0)
        assert found.dtype.names == expected.dtype.names
        # a step of co-simulation holds the inputs with which it began
        now = slice(None) if kind == "ModelExchange" else slice(None, -1)
        then = slice(None) if kind == "ModelExchange" else slice(1, None)
        for name in expected.dtype.names[1:]:
            assert np.array_equal(found[name][then], expected[name][now]), name


@pytest.mark.parametrize("version", [2, 3])
def test_description_has_units_limits_and_full_dependencies(version, made, exported_models):
    path, whole, _ = made("several", version)
    description = fmpy.read_model_description(str(path))
    by_name = {variable.name: variable for variable in description.modelVariables}
    assert by_name["a"].unit == "m"
    assert by_name["a"].displayUnit == "mm"
    assert by_name["few"].unit == "bar"
    low, high = whole.domain()[[v.name for v in whole.inputs].index("a")]
    assert (float(by_name["a"].min), float(by_name["a"].max)) == (low, high)
    assert low <= float(by_name["a"].start) <= high
    assert float(by_name["out put"].max) == 2.0
    bar = next(unit for unit in description.unitDefinitions if unit.name == "bar")
    assert (bar.baseUnit.kg, bar.baseUnit.m, bar.baseUnit.s, bar.baseUnit.factor) == (1, -1, -2, 1e5)
    psi = next(display for display in bar.displayUnits if display.name == "psi")
    assert psi.factor == pytest.approx(14.5037738)
    for unknown in [*description.outputs, *description.initialUnknowns]:
        names = {variable.name for variable in unknown.dependencies}
        assert names == ({"b", "c"} if unknown.variable.name == "few" else {"a", "b", "c"})


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("which", ["several", "shipped"])
def test_directional_and_adjoint_derivatives_are_those_of_the_package(which, version, made):
    _, whole, _ = made(which, version)
    n, m = len(whole.inputs), len(whole.models)
    fmu = instance(made, which, version, "ModelExchange")
    knowns, unknowns = list(range(n)), list(range(n, n + m))
    X = whole.points(90)
    for x, expected in zip(X, whole.slopes(X), strict=True):
        outputs(fmu, whole, x, version)
        for i in range(n):
            seed = np.eye(n)[i].tolist()
            found = fmu.getDirectionalDerivative(unknowns, knowns, seed)
            assert found == pytest.approx(expected[:, i], rel=1e-8, abs=1e-9 * np.abs(expected).max())
        if version == 3:
            seed = (1.0 + np.arange(m)).tolist()
            found = fmu.getAdjointDerivative(unknowns, knowns, seed, n)
            assert found == pytest.approx(seed @ expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())
    with pytest.raises(Exception, match="irectionalDerivative"):  # never silently 0
        fmu.getDirectionalDerivative(knowns, knowns, [1.0] * n)
    with pytest.raises(Exception, match="irectionalDerivative"):
        fmu.getDirectionalDerivative(unknowns, unknowns, [1.0] * m)
    fmu.terminate()
    fmu.freeInstance()


@pytest.mark.parametrize("version", [2, 3])
def test_casadi_differentiates(version, made):
    _, whole, folder = made("several", version)
    builder = casadi.DaeBuilder("model", str(folder))
    assert builder.u() == [variable.name for variable in whole.inputs]
    function, u = builder.create("f", ["u"], ["y"]), casadi.MX.sym("u", len(whole.inputs))
    jacobian = casadi.Function("jacobian", [u], [casadi.jacobian(function(u), u)])
    X = whole.points(60)
    for x, y, slopes in zip(X, whole.predict(X), whole.slopes(X), strict=True):
        assert np.array_equal(np.array(function(x)).ravel()[: len(y)], y)
        assert np.array(jacobian(x))[: len(y)] == pytest.approx(slopes, abs=1e-12)


@pytest.mark.parametrize("version", [2, 3])
def test_several_instances_states_and_what_is_not_a_number(version, made):
    _, whole, _ = made("several", version)
    one, other = (instance(made, "several", version, name=name) for name in ("one", "other"))
    X = whole.points(60)[[0, 1, 59]]
    expected = np.column_stack([whole.predict(X), whole.outside(X)])
    assert outputs(one, whole, X[0], version) == expected[0].tolist()
    assert outputs(other, whole, X[1], version) == expected[1].tolist()
    outs = list(range(len(whole.inputs), len(whole.inputs) + len(whole.models) + 1))
    read = one.getReal if version == 2 else one.getFloat64
    assert read(outs) == expected[0].tolist()
    end = "state" if version == 2 else "State"
    get, put, free, save = (getattr(one, f"{verb}FMU{end}") for verb in ("get", "set", "free", "serialize"))
    load = one.deSerializeFMUstate if version == 2 else one.deserializeFMUState
    state = get()
    stored = save(state)
    assert outputs(one, whole, X[2], version) == expected[2].tolist()
    assert expected[2, -1] > 0.0
    put(state)
    assert read(outs) == expected[0].tolist()
    outputs(one, whole, X[2], version)
    again = load(stored)
    put(again)
    assert read(outs) == expected[0].tolist()
    free(state)
    free(again)
    with_nan = outputs(one, whole, [np.nan, *X[0, 1:]], version)
    assert np.all(np.isnan(with_nan[:-1]))
    assert with_nan[-1] == np.finfo(np.float64).max
    assert outputs(one, whole, X[0], version) == expected[0].tolist()
    one.reset()
    for fmu in (one, other):
        fmu.freeInstance()


@pytest.mark.parametrize(("version", "count"), [(2, 44), (3, 75)])
def test_all_functions_of_the_standard_are_exported_and_nothing_else(version, count, made):
    _, _, folder = made("several", version)
    library = next((folder / "binaries").rglob("*.so"))
    text = subprocess.run(["nm", "-D", "--defined-only", str(library)], capture_output=True, text=True).stdout
    names = {line.split()[-1] for line in text.splitlines()}
    header = (folder / "sources" / f"fmi{version}Functions.h").read_text()
    declared = set(re.findall(rf"FMI{version}_Export\s+fmi{version}\w+TYPE\s+(\w+);", header))
    assert len(declared) == count
    assert names == declared


@pytest.mark.parametrize("version", [2, 3])
def test_sources_are_strict_c_and_link_statically_with_the_prefix(version, made):
    _, whole, folder = made("several", version)
    flags = "-std=c99 -O2 -Wall -Wextra -Werror -Wconversion -Wshadow -pedantic".split()
    prefix = [f"-DFMI2_FUNCTION_PREFIX={whole.name}_"] if version == 2 else []
    subprocess.run(["gcc", *flags, *prefix, "-c", f"fmi{version}.c"], cwd=folder / "sources", check=True)
    text = subprocess.run(
        ["nm", "--defined-only", "-g", f"fmi{version}.o"], cwd=folder / "sources", capture_output=True, text=True
    ).stdout
    assert all(line.split()[-1].startswith(f"{whole.name}_fmi{version}") for line in text.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_without_compiler_holds_sources_that_the_importer_compiles(version, exported_models, tmp_path):
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    made = export_fmu(exported_models["regions"], tmp_path / "s.fmu", version=version, compiler="")
    assert made.binaries == ()
    folder = fmpy.extract(str(made.main), unzipdir=str(tmp_path / "in"))
    assert not (tmp_path / "in/binaries").exists()
    (tmp_path / "build").mkdir()
    build_platform_binary(str(folder), build_dir=str(tmp_path / "build"))
    whole = bundle(exported_models["regions"])
    inputs, expected = reference(tmp_path / "in", whole, version)
    found = fmpy.simulate_fmu(str(folder), fmi_type="ModelExchange", input=inputs, output_interval=0.01, stop_time=1.0)
    assert np.allclose(found["out put"], expected["out put"], rtol=0, atol=1e-12)


def test_the_file_is_the_same_whenever_it_is_written_and_its_token_follows_the_model(exported_models, tmp_path):
    paths = [export_fmu(exported_models["single"], tmp_path / f"{k}.fmu", compiler="").main for k in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with zipfile.ZipFile(paths[0]) as archive:
        assert "documentation/index.html" in archive.namelist()
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
        assert b"Redistribution and use" in archive.read("documentation/licenses/LICENSE-FMI.txt")
    other = export_fmu(exported_models["linear"], tmp_path / "o.fmu", name="y", compiler="").main
    tokens = [fmpy.read_model_description(str(path)).instantiationToken for path in (paths[0], other)]
    assert tokens[0] != tokens[1]


def test_names_that_clash_or_are_odd(exported_models, tmp_path):
    model = exported_models["single"][0]
    names = ("domain", "time", "a <&> b\n")
    odd = Model(tuple(Variable(name, "weird/unit") for name in names), Variable("y", "psi"), model.networks)
    path = export_fmu([odd], tmp_path / "odd.fmu", compiler="").main
    assert validation.validate_fmu(str(path)) == []
    found = [variable.name for variable in fmpy.read_model_description(str(path)).modelVariables]
    assert found == ["domain", "time", "a <&> b", "y", "domain_", "time_"]


def test_bad_input(exported_models, tmp_path):
    models = exported_models["constant"]
    for options, message in [
        ({"path": tmp_path / "x.zip"}, "ends in .fmu"),
        ({"path": tmp_path / "x.fmu", "version": 1}, "FMI version 1"),
        ({"path": tmp_path / "x.fmu", "compiler": "no-such-cc"}, "'no-such-cc' is not installed"),
    ]:
        with pytest.raises(InputError, match=message):
            export_fmu(models, **options)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        export_fmu(models, tmp_path / "file" / "x.fmu", compiler="")
    with pytest.raises(InputError, match="false cannot compile"):
        export_fmu(models, tmp_path / "x.fmu", compiler="false")  # a command that fails
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_binaries_for_other_platforms(version, exported_models, tmp_path):
    pytest.importorskip("ziglang")
    made = export_fmu(exported_models["constant"], tmp_path / "x.fmu", version=version, cross=True)
    assert len(made.binaries) == 5
    starts = {"linux": b"\x7fELF", "windows": b"MZ", "darwin": b"\xcf\xfa\xed\xfe"}
    with zipfile.ZipFile(made.main) as archive:
        found = {name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")}
    assert len(found) == 5
    ending = {".so": "linux", ".dll": "windows", ".dylib": "darwin"}
    for name, data in found.items():
        assert data.startswith(starts[ending[name[name.rindex(".") :]]])
    folders = {name.split("/")[1] for name in found}
    assert folders >= ({"linux64", "win64", "darwin64"} if version == 2 else {"x86_64-windows", "aarch64-darwin"})


def test_other_platforms_need_ziglang(exported_models, tmp_path, monkeypatch):
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install ziglang"):
        export_fmu(exported_models["constant"], tmp_path / "x.fmu", cross=True)
    assert list(tmp_path.iterdir()) == []
