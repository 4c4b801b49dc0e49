import copy
import json
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from polydraulic import load_models
from polydraulic.errors import InputError
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import (
    Model,
    Network,
    Node,
    PerceptronRegressor,
    Split,
    Variable,
    dump_models,
    parse_models,
    save_models,
)
from polydraulic.networks.model.nodes import DOUBLE, KIND_NAMES

X = np.random.default_rng(5).uniform(-1.0, 1.0, size=(300, 2))
Y = np.abs(X[:, 0]) * X[:, 1]
MODEL = Model(  # |x| p in two regions
    (Variable("x", "m"), Variable("p")),
    Variable("q", "m3/s"),
    tuple(
        Network(
            (Node(DOUBLE, (0, 1), (0.0, 0.0, 0.0, 0.0, 0.0, sign, 0.0, 0.0)),),
            (0.0, 0.0), (1.0, 0.5), (-1.0, -1.0), (1.0, 1.0), 0.0, 0.5, -1.0, 1.0,
        )
        for sign in (-1.0, 1.0)
    ),
    Split(0, 0.0, 0, 1),
    {"fse": 0.01},
)  # fmt: skip
DATA = json.loads(dump_models([MODEL]))


def test_reading_gives_what_was_written(tmp_path):
    path = tmp_path / "model.json"
    path.write_text(dump_models([MODEL, MODEL]))
    assert load_models(path) == [MODEL, MODEL]
    assert np.array_equal(load_models(path)[0].predict(X), MODEL.predict(X))


def test_a_model_file_ends_in_json(tmp_path):
    with pytest.raises(InputError, match=r"power.txt: a model file ends in .json"):
        save_models([MODEL], tmp_path / "power.txt")
    assert list(tmp_path.iterdir()) == []


def test_files_follow_the_published_schema():
    schema = json.loads((files("polydraulic.networks.model") / "model.schema.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    perceptron = PerceptronRegressor(hidden_units=2, max_iter=2, n_starts=1).fit(X, Y).to_model()
    assert not list(validator.iter_errors(json.loads(dump_models([MODEL, perceptron]))))
    assert not list(validator.iter_errors(json.loads(dump_models(shipped_models()))))
    assert schema["$defs"]["node"]["properties"]["kind"]["enum"] == list(KIND_NAMES)
    assert list(validator.iter_errors(json.loads(change((*N, "nodes", 0, "kind"), "quadruple"))))
    assert list(validator.iter_errors(json.loads(change((*M, "partition"), "left"))))
    assert not list(validator.iter_errors(json.loads(dynamic())))
    assert list(validator.iter_errors(json.loads(dynamic(raster=0.0))))
    assert not list(validator.iter_errors(json.loads(dynamic(strength=STRENGTH))))
    assert list(validator.iter_errors(json.loads(dynamic(strength=STRENGTH | {"age": 1.0}))))


def change(where, value):
    data = copy.deepcopy(DATA)
    item = data
    for key in where[:-1]:
        item = item[key]
    item[where[-1]] = value
    return json.dumps(data)


LAGS = [{"signal": "p", "steps": 1}, {"signal": "q", "steps": 2}]


STRENGTH = {"rows": 32, "spread": 0.1, "lean": 0.05, "memory": 1e4, "noise": 1e-3}


def dynamic(**other):
    return change((*M, "dynamics"), {"lags": LAGS, "step": [-1.0, 1.0], "raster": None} | other)


M, N = ("models", 0), ("models", 0, "networks", 0)
OLDER = (Path(__file__).parent / "schema_1.json").read_text()


def older(**other):
    data = json.loads(OLDER)
    data["models"][0] |= other
    return json.dumps(data)


def test_files_of_schema_1_are_read():
    """The networks of the file are 100, 200, ... 600 + u and, last, (p - 15) / 5 clamped to [-1, 1], cubed; numbered with p fastest."""
    (model,) = parse_models(OLDER, "schema_1.json")
    u, p, q = (
        [0.5, 1.0, 1.5, 2.0, 2.5, 2.5],
        [5.0, 15.0, 10.0, 11.0, 10.0, 17.5],
        [100.5, 201.0, 301.5, 402.0, 502.5, 0.125],
    )
    assert model.predict(np.column_stack([u, p])) == pytest.approx(q, rel=1e-12)
    assert [str(variable) for variable in (*model.inputs, model.output)] == ["u [V]", "p [bar]", "q [l/min]"]
    assert model.region_names()[1] == "u in (-inf, 1] and p in (10, inf)"
    assert model.training == {"cpm": 1.0}
    again = dump_models([model])
    assert json.loads(again)["schema"] == 2
    assert parse_models(again, "again") == [model]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not a model file"),
        ("[]", "not a polydraulic model file"),
        ("{}", "not a polydraulic model file"),
        (change(("schema",), 3), "has schema 3, this version reads 1 to 2; it was written by a newer version: update"),
        (change(("schema",), 0), "has schema 0, this version reads 1 to 2; write the model again"),
        (change(("schema",), "2"), "has schema '2', this version reads 1 to 2; write the model again"),
        (change(("schema",), True), "has schema True, this version reads 1 to 2"),
        (change(("schema",), 1), "damaged model file: missing 'edges'"),
        (older(edges=[{"input": 2, "at": [1.0]}]), "a split of input 2"),
        (older(edges=[{"input": "u", "at": [1.0]}]), "a split of input 'u'"),
        (older(edges=[{"input": 0, "at": [1.0]}, {"input": 0, "at": [2.0]}]), "the edges .* of input 0"),
        (older(edges=[{"input": 0, "at": []}]), "the edges .* of input 0"),
        (older(edges=[{"input": 0, "at": [2.0, 1.0]}, {"input": 1, "at": [10.0]}]), "a region that is empty"),
        (older(edges=[{"input": 0, "at": [1.0, 2.0]}]), "the partition leads to networks"),
        (change(("models",), []), "holds no model"),
        (change((*M, "networks"), DATA["models"][0]["networks"][:1]), "networks \\[0, 1\\] of 1"),
        (change((*M, "partition", "input"), 7), "a split of input 7"),
        (change((*M, "partition", "at"), None), "partition holds None"),
        (change((*M, "partition", "below"), 1), "leads to networks"),
        (change((*M, "partition", "below"), "left"), "the partition holds 'left'"),
        (change((*M, "partition", "below"), [DATA]), "the partition holds"),
        (change((*M, "partition", "below"), {"input": 0, "at": 1.0, "below": 0, "above": 2}), "more splits|networks"),
        (change((*N, "x_scale"), [0.0, 1.0]), "x_scale must be positive"),
        (change((*N, "y_scale"), -1.0), "y_scale is -1.0; it must not be negative"),
        (change((*N, "x_mean"), [0.0]), "x_mean has 1 values for 2 inputs"),
        (change((*N, "y_mean"), "high"), "unitizer holds 'high'"),
        (change((*N, "y_mean"), float("nan")), "unitizer holds nan"),
        (change((*N, "x_low"), [5.0, 5.0]), "x_low exceeds x_high"),
        (change((*N, "nodes", 0, "kind"), "quadruple"), "unknown node kind 'quadruple'"),
        (change((*N, "nodes", 0, "inputs"), [0]), r"node of \(0,\)"),
        (change((*N, "nodes", 0, "inputs"), [0, 9]), r"node 1 reads \(0, 9\); it may read slots 0 to 1"),
        (change((*N, "nodes", 0, "inputs"), [-1, 0]), "it may read slots"),
        (
            change((*N, "nodes", 0), {"kind": "linear", "inputs": [0] * 10**6, "coef": [1.0] * 10**6}),
            "reads a slot twice",
        ),
        (change((*N, "nodes", 0, "coef"), [1.0]), "with 1 coefficients"),
        (change((*M, "inputs"), 3), "damaged model file"),
        (dynamic(lags=LAGS[:1]), "1 lags for 2 inputs"),
        (dynamic(lags=[*LAGS[:1], {"signal": "q", "steps": 0}]), "q is read 0 steps ago"),
        (dynamic(lags=[*LAGS[:1], {"signal": "p", "steps": 1.5}]), "p is read 1.5 steps ago"),
        (dynamic(step=[1.0, -1.0]), "the smallest step 1.0 exceeds"),
        (dynamic(raster=0.0), "raster is 0.0"),
        (dynamic(strength=STRENGTH | {"rows": 0}), "a strength over 0 rows"),
        (dynamic(strength=STRENGTH | {"lean": 0.0}), "lean of a strength is 0.0: it is above 0"),
        (dynamic(strength=STRENGTH | {"age": 1.0}), r"a strength of \['age', 'lean'"),
        (dynamic(strength={"rows": 2}), "missing 'spread'|a strength of"),
        (dynamic(lags=[*LAGS[:1], {"signal": "p", "steps": 10**30}]), "it may be 0 to 1000000"),
        (change((*N, "y_low"), 1e300), "y_low = 1e\\+300 exceeds y_high"),
        (change((*N, "x_scale"), [1e-310, 1.0]), "overflows in its domain"),
        (change((*N, "x_high"), [1e308, 1e308]), "overflows in its domain"),
        (change((*N, "y_scale"), 1.7e308), "overflows in its domain"),
        (change((*N, "y_mean"), 10**400), "unitizer holds a whole number of hundreds of digits"),
        (change((*N, "x_mean", 0), -(10**400)), "x_mean holds a whole number of hundreds of digits"),
        (dynamic(lags=[*LAGS[:1], {"signal": "p", "steps": 10**400}]), "p is read a whole number of hundreds"),
        (dynamic(raster=10**400), "raster holds a whole number"),
        (change((*M, "inputs", 0, "name"), 7), "a variable of name 7, unit 'm'"),
        (change((*M, "output", "unit"), None), "unit None"),
        (change((*M, "inputs"), []), "a model without inputs"),
        (change((*M, "training"), [["fse", 1.0]]), "training holds"),
        (change((*M, "training"), {"fse": float("nan")}), "not JSON compliant"),
        ('{"schema": ' + "9" * 5000 + "}", "not a model file"),
        ("[" * 50_000, "nested too deep"),
        ('{"format": ' * 50_000, "nested too deep"),
        (json.dumps({k: v for k, v in DATA.items() if k != "models"}), "missing 'models'"),
    ],
)
def test_damaged_files_are_one_clear_error(text, message):
    with pytest.raises(InputError, match=message):
        parse_models(text, "m.json")


def test_a_partition_deeper_than_the_stack_is_one_error():
    data = copy.deepcopy(DATA)
    model, n = data["models"][0], 5000
    model["networks"] = [model["networks"][0]] * n
    deep = ", ".join(f'{{"input": 0, "at": {k}.0, "below": {k}, "above": ' for k in range(n - 1)).replace(", {", "{")
    text = json.dumps(data).replace(json.dumps(model["partition"]), deep + str(n - 1) + "}" * (n - 1))
    with pytest.raises(InputError, match="nested too deep"):
        parse_models(text, "m.json")


def test_a_missing_file_is_one_error(tmp_path):
    with pytest.raises(InputError, match="^model file .*none.json: no such file$"):
        load_models(tmp_path / "none.json")
    (tmp_path / "other.json").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="other.json: cannot be read as a model file"):
        load_models(tmp_path / "other.json")


def test_a_strength_reads_back_and_files_without_one_are_as_before():
    (model,) = parse_models(dynamic(strength=STRENGTH), "m")
    assert vars(model.dynamics.strength) == STRENGTH
    assert parse_models(dump_models([model]), "m") == [model]
    (model,) = parse_models(dynamic(), "m")
    assert model.dynamics.strength is None
    assert "strength" not in dump_models([model])
