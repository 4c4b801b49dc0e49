"""Generated C, compiled strictly and run: the same bits as the package."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings

from helpers.exports import NAMES, networks
from helpers.in_turn import in_turn
from polydraulic.errors import InputError
from polydraulic.export import bundle, export_c, to_c
from polydraulic.export.c import answers
from polydraulic.networks import Model, Network, Node, Variable
from polydraulic.networks.model.nodes import SINGLE

FLAGS = "-std=c99 -O2 -Wall -Wextra -Werror -Wconversion -Wdouble-promotion -Wshadow -pedantic".split()
SANITIZERS = ["-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]


class Compiled:
    """The functions of an exported source."""

    def __init__(self, models, folder, real="double", name=None):
        self.whole, self.type = bundle(models, name=name), np.float64 if real == "double" else np.float32
        self.source = next(p for p in export_c(models, folder, real=real, name=name) if p.suffix == ".c")
        library = folder / f"{self.whole.name}.so"
        subprocess.run(["gcc", *FLAGS, "-shared", "-fPIC", str(self.source), "-o", str(library), "-lm"], check=True)
        self.library = ctypes.CDLL(str(library))

    def __call__(self, X):
        """Status, outputs, outputs with slopes, slopes, distance outside, its slopes; one row each."""
        n, m = len(self.whole.inputs), len(self.whole.models)
        value, slopes, outside = (getattr(self.library, self.whole.name + end) for end in ("", "_slopes", "_outside"))
        outside.restype = ctypes.c_double if self.type is np.float64 else ctypes.c_float
        status, far = np.empty(len(X), dtype=int), np.empty(len(X))
        y, again, dy, dfar = (np.empty((len(X), size), dtype=self.type) for size in (m, m, n * m, n))
        X = np.ascontiguousarray(X, dtype=self.type)
        for i in range(len(X)):
            x, *rows = (array[i].ctypes.data_as(ctypes.c_void_p) for array in (X, y, again, dy, dfar))
            status[i] = value(x, rows[0])
            assert slopes(x, rows[1], rows[2]) == status[i]
            far[i] = outside(x, rows[3])
        return status, y, again, dy.reshape(-1, m, n), far, dfar


@pytest.mark.parametrize("which", NAMES)
def test_double_c_equals_the_package_bit_for_bit_with_its_slopes_and_domain(which, exported_models, tmp_path):
    function = Compiled(exported_models[which], tmp_path)
    X = function.whole.points(600)
    status, y, again, dy, far, dfar = function(X)
    assert np.array_equal(y, function.whole.predict(X))
    assert np.array_equal(again, y)
    expected = function.whole.slopes(X)
    assert np.allclose(dy, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    assert np.array_equal(far, function.whole.outside(X))
    assert np.array_equal(status, far > 0.0)
    assert 20 < np.sum(status) < 400
    step = 1e-6 * np.ptp(function.whole.domain(), axis=1)  # the distance has the slopes of finite differences
    out = X[status == 1][:20]
    ahead = np.stack([function.whole.outside(out + np.diag(step)[i]) for i in range(len(step))], axis=1)
    assert np.allclose(dfar[status == 1][:20] * step, ahead - far[status == 1][:20, None], atol=1e-9)


@pytest.mark.parametrize(("which", "real"), in_turn(NAMES, ["double", "float"]))
def test_tables_give_the_bits_of_straight_line_code(which, real, exported_models, tmp_path, monkeypatch):
    found = []
    for form, most in (("straight", 10**9), ("tables", 0)):
        monkeypatch.setattr(answers, "STRAIGHT", most)
        (tmp_path / form).mkdir()
        function = Compiled(exported_models[which], tmp_path / form, real, name="net")
        assert ("own_net_node" in function.source.read_text()) == (form == "tables")
        found.append(function)
    X = found[0].whole.points(600)
    X[:3, 0] = np.nan, np.inf, -np.inf
    slopes = 3
    for place, (straight, tabled) in enumerate(zip(*(function(X) for function in found), strict=True)):
        if real == "float" and place == slopes:  # three times a coefficient is rounded there, not before it is written
            size = np.abs(straight[3:]).max(axis=0)
            assert np.all(np.abs(straight - tabled)[3:] <= 1e-3 * size)
        else:
            assert straight.tobytes() == tabled.tobytes()  # the signs of zeros too


def test_the_form_follows_the_number_of_networks(exported_models):
    few, many = exported_models["regions"], exported_models["shipped"]
    assert len(few[0].networks) <= answers.STRAIGHT < len(many[0].networks)
    header, source = to_c(bundle(few, name="f"))
    assert "6 networks as straight-line code" in header
    assert "own_net_node" not in source
    header, source = to_c(bundle(many, name="f"))
    assert "14 networks as tables" in header
    assert "value_0_0" not in source


def test_float_tables_refuse_slopes_that_no_float_holds(monkeypatch):
    node = Node(SINGLE, (0,), (0.0, 0.0, 0.0, 2e38))
    model = Model((Variable("a"),), Variable("y"), (Network((node,), (0.0,), (1.0,), (-0.1,), (0.1,), 0.0, 1.0),))
    for most in (8, 0):
        monkeypatch.setattr(answers, "STRAIGHT", most)
        with pytest.raises(InputError, match="does not fit into a float"):
            to_c(bundle([model]), real="float")


@pytest.mark.parametrize("which", NAMES)
def test_float_c_is_close(which, exported_models, tmp_path):
    function = Compiled(exported_models[which], tmp_path, "float")
    X, middle = function.whole.points(600)[:400], function.whole.domain().mean(axis=1)
    X = (middle + 0.98 * (X - middle)).astype(np.float32).astype(np.float64)  # away from borders
    _, y, _, dy, _, _ = function(X)
    for found, expected in ((y, function.whole.predict(X)), (dy, function.whole.slopes(X))):
        error = np.abs(found - expected) - 1e-30
        size = np.abs(expected).max(axis=0)
        near = (error <= 1e-3 * size).reshape(len(X), -1).all(axis=1)
        if which == "shipped":  # large terms that cancel cost digits all over some regions: docs/export.md
            assert np.all(error <= 1e-2 * size)
        else:
            assert np.mean(near) >= 0.99  # slopes jump where the output meets its bounds
    code = re.sub(r"/\*.*?\*/", "", function.source.read_text(), flags=re.DOTALL)
    assert "double" not in code
    assert not re.search(r"\d\.\d+(e[+-]?\d+)?(?![\df]|e[+-])", code)  # all literals are floats


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("which", ["constant", "regions", "several"])
def test_the_source_tests_itself_under_sanitizers_and_is_cpp_too(which, real, exported_models, tmp_path):
    source = export_c(exported_models[which], tmp_path, name="net", real=real).files[1]
    program = tmp_path / "net"
    for compiler, flags in (("gcc", FLAGS), ("g++", ["-x", "c++", "-std=c++11", *FLAGS[2:]])):
        if shutil.which(compiler) is None:
            continue
        command = [compiler, *flags, *SANITIZERS, "-DNET_SELF_TEST", str(source), "-o", str(program), "-lm"]
        subprocess.run(command, check=True)
        assert subprocess.run([str(program)]).returncode == 0
    text = source.read_text()
    for word in ("malloc", "stdio", "printf"):
        assert word not in text


@pytest.mark.slow
@settings(max_examples=40)
@given(networks())
def test_any_network_compiles_strictly_and_gives_the_bits_of_the_package(tmp_path_factory, network):
    model = Model(tuple(Variable(f"x{i}") for i in range(network.n_inputs)), Variable("y"), (network,))
    function = Compiled([model], tmp_path_factory.mktemp("c"))
    X = function.whole.points(60)
    _, y, again, dy, far, _ = function(X)
    assert np.array_equal(y[:, 0], model.predict(X))
    assert np.array_equal(again, y)
    expected = function.whole.slopes(X)
    assert np.allclose(dy, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max() + 1e-12)
    assert np.array_equal(far, function.whole.outside(X))


def test_the_self_test_finds_a_wrong_number(exported_models, tmp_path):
    source = export_c(exported_models["single"], tmp_path, name="net").files[1]
    text = source.read_text()
    gain = re.search(r"\) \* (\d\.\d+);", text)[1]
    source.write_text(text.replace(gain, f"{float(gain) * (1 + 1e-6)!r}", 1))
    subprocess.run(["gcc", "-DNET_SELF_TEST", str(source), "-o", str(tmp_path / "net"), "-lm"], check=True)
    assert subprocess.run([str(tmp_path / "net")]).returncode == 1


def test_what_is_not_a_number_gives_that_and_a_flag_and_infinite_inputs_are_outside(exported_models, tmp_path):
    function = Compiled(exported_models["several"], tmp_path)
    X = np.zeros((3, 3))
    X[0, 2], X[1, 0], X[2, 0] = np.nan, np.nan, np.inf
    status, y, _, dy, far, _ = function(X)
    assert status.tolist() == [2, 2, 1]
    assert np.all(np.isnan(y[:2]))
    assert np.all(np.isnan(dy[:2]))
    assert np.all(far[:2] == np.finfo(np.float64).max)
    assert np.all(np.isfinite(y[2]))
    assert np.isinf(far[2])


def test_names_units_and_domain_are_comments_and_constants(exported_models, tmp_path):
    header, source = to_c(bundle(exported_models["regions"], name="f"))
    assert " * f: out put [Pa] from" in header
    assert " *   x[0]  a [m], domain -" in header
    assert "#define F_INPUT_A 0" in header
    assert "#define F_OUTPUT_OUT_PUT 0" in header
    assert "/* out put: a in (-0.3, 0.4] and c in (0, inf) */" in source
    function = Compiled(exported_models["regions"], tmp_path, name="f").library
    texts = ctypes.c_char_p * 3
    assert list(texts.in_dll(function, "f_input_names")) == [b"a", b"b", b"c"]
    assert list(texts.in_dll(function, "f_input_units")) == [b"m", b"", b""]
    high = list((ctypes.c_double * 3).in_dll(function, "f_domain_high"))
    assert high == bundle(exported_models["regions"]).domain()[:, 1].tolist()


def test_odd_names_are_mapped_and_compile(exported_models, tmp_path):
    model = exported_models["constant"][0]
    odd = tuple(Variable(name, "*/ ??/") for name in ('a"b\\', "a b", "a_b"))
    odd_model = Model(odd, Variable("clamp", "Öl\n"), model.networks)
    whole = bundle([odd_model])
    assert whole.name == "clamp_"
    assert whole.renamed() == {'a"b\\': "a_b_", "a b": "a_b", "a_b": "a_b_2", "clamp": "clamp_"}
    function = Compiled([odd_model], tmp_path)
    assert (ctypes.c_char_p * 3).in_dll(function.library, "clamp__input_names")[0] == b'a"b\\'
