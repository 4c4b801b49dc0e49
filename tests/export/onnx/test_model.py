"""ONNX graphs in ONNX Runtime."""

import json

import numpy as np
import onnx
import onnxruntime
import pytest

from helpers.exports import NAMES
from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.export import bundle
from polydraulic.export.c import answers
from polydraulic.export.onnx.model import export_onnx, to_onnx


def run(model, X):
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    return session.run(["y", "domain"], {"x": X})


@pytest.mark.parametrize("which", NAMES)
def test_double_graphs_agree_to_rounding_inside_and_outside(which, exported_models):
    whole = bundle(exported_models[which])
    X = whole.points(600)
    y, domain = run(to_onnx(whole), X)
    expected = whole.predict(X)
    assert np.all(np.abs(y - expected) <= 1e-13 * np.abs(expected).max(axis=0))
    assert np.array_equal(domain[:, 0], whole.outside(X))


@pytest.mark.parametrize("which", NAMES)
def test_graphs_of_tables_agree_to_rounding_inside_and_outside(which, exported_models, monkeypatch):
    whole = bundle(exported_models[which])
    X = whole.points(600)
    straight, _ = run(to_onnx(whole), X)
    monkeypatch.setattr(answers, "STRAIGHT", 0)
    y, domain = run(to_onnx(whole), X)
    assert np.all(np.abs(y - straight) <= 1e-13 * np.abs(straight).max(axis=0))
    assert np.array_equal(domain[:, 0], whole.outside(X))


def test_a_graph_of_many_regions_grows_with_the_longest_network_alone(exported_models):
    few, many = (to_onnx(bundle(exported_models[which])) for which in ("regions", "shipped"))
    longest = max(len(network.nodes) for network in exported_models["shipped"][0].networks)
    assert len(many.graph.node) < 120 * longest
    assert not any(node.op_type == "GatherElements" for node in few.graph.node)


def test_float_graphs_are_close(exported_models):
    whole = bundle(exported_models["perceptron"])
    X = whole.points(300)[:200].astype(np.float32)
    y, _ = run(to_onnx(whole, real="float"), X)
    assert y.dtype == np.float32
    assert y == pytest.approx(whole.predict(X.astype(float)), abs=1e-5)


@pytest.mark.parametrize(("offset", "coarse"), [(0.0, False), (100.0, False), (1e4, True), (1e9, True)])
def test_inputs_far_from_zero_are_named_where_floats_are_coarse_for_them(tmp_path, offset, coarse):
    rng = np.random.default_rng(0)
    X = offset + rng.uniform(size=(80, 1))
    model = AbductiveRegressor(max_layers=1).fit(X, (X[:, 0] - offset) ** 2).to_model()
    notes = export_onnx([model], tmp_path / "m.onnx", real="float").notes
    assert [("a float tells numbers apart by" in note, note.split(":")[0]) for note in notes] == [(True, "x0")] * coarse
    assert export_onnx([model], tmp_path / "m.onnx").notes == ()


def test_numbers_that_no_float_holds_are_refused(tmp_path):
    X = 1e39 * np.random.default_rng(0).uniform(size=(80, 1))
    model = AbductiveRegressor(max_layers=1).fit(X, X[:, 0] / 1e39).to_model()
    with pytest.raises(
        InputError, match=r"numbers of 'y' exceed what a float can hold, 3.4e38: .* or export as double"
    ):
        export_onnx([model], tmp_path / "m.onnx", real="float")
    assert not (tmp_path / "m.onnx").exists()
    export_onnx([model], tmp_path / "m.onnx")


def test_what_is_not_a_number_gives_that_and_is_outside(exported_models):
    whole = bundle(exported_models["several"])
    X = whole.points(9)
    X[4, 1] = np.nan
    y, domain = run(to_onnx(whole), X)
    assert np.isnan(y).all(axis=1).tolist() == [k == 4 for k in range(9)]
    assert domain[4, 0] == np.finfo(np.float64).max


def test_file_with_names_units_and_domain(exported_models, tmp_path):
    path = export_onnx(exported_models["regions"], tmp_path / "r.onnx").main
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    assert (model.ir_version, model.opset_import[0].version) == (8, 17)
    about = {prop.key: json.loads(prop.value) for prop in model.metadata_props}
    assert about["outputs"] == [{"name": "out put", "unit": "Pa"}]
    assert [item["name"] for item in about["inputs"]] == ["a", "b", "c"]
    assert about["inputs"][0]["low"] == bundle(exported_models["regions"]).domain()[0, 0]


def test_bad_input(exported_models, tmp_path, monkeypatch):
    whole = bundle(exported_models["constant"])
    with pytest.raises(InputError, match=r"ends in .onnx"):
        export_onnx(exported_models["constant"], tmp_path / "x")
    with pytest.raises(InputError, match="real = 'half'"):
        to_onnx(whole, real="half")
    with pytest.raises(InputError, match="opset = 9"):
        to_onnx(whole, opset=9)
    monkeypatch.setitem(__import__("sys").modules, "onnx", None)
    with pytest.raises(InputError, match=r"pip install polydraulic\[export\]"):
        to_onnx(whole)
