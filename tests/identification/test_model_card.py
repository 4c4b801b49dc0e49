"""Model cards, and whether a model still holds."""

import json
from html import escape

import numpy as np
import pytest

from polydraulic import AbductiveRegressor, load_models, save_models
from polydraulic.errors import InputError
from polydraulic.identification import fit_table, write_card
from polydraulic.identification.model_card import _coverage_of
from polydraulic.identification.validity import validity
from polydraulic.tables import Table


def log(n=1500, scale=1.0, reach=1.0, seed=0):
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(n)
    a, b = reach * np.sin(t), np.cos(0.37 * t)
    y = scale * np.abs(a) * (2.0 + b) + 0.01 * rng.normal(size=n)
    return Table({"time": t, "a": a, "b": b, "y": y}, {"time": "s", "a": "m", "y": "Pa"})


@pytest.fixture(scope="module")
def found():
    return fit_table(log(), ["a", "b"], ["y"], estimator=AbductiveRegressor(max_layers=2), edges={"a": [0.0]})


@pytest.fixture(scope="module")
def fits(found):
    return found.outputs


def test_the_card_says_what_an_engineer_asks(found, tmp_path):
    card = write_card(found, tmp_path / "card.html", source="machine.parquet")
    assert json.loads((tmp_path / "card.card.json").read_text()) == json.loads(json.dumps(card))
    model = card["models"][0]
    assert card["data"]["rows"] == 1500
    assert card["warnings"] == []
    assert card["data"]["held_out"] == "blocks of time"
    assert card["data"]["seconds"] == pytest.approx(14.99)
    assert model["proved_low"] < 0.1 < 2.5 < model["proved_high"]
    assert all(
        model["proved_low"] <= r["proved_low"] <= r["proved_high"] <= model["proved_high"] for r in model["regions"]
    )
    page = (tmp_path / "card.html").read_text()
    for text in ("machine.parquet", "blocks of time", "Proved", "Domain", "90% intervals", "y [bar]", "(double)"):
        assert text in page
    assert page.count("data:image/svg+xml") == 3
    assert 'src="http' not in page


@pytest.mark.parametrize(
    "odd",
    [("p_{", "$x", r"$\frac$"), ("50 %", "a$b$c", "<b>&amp;"), ("\\", "#^~", "w" * 300)],
    ids=["tex", "signs", "long"],
)
def test_names_that_are_no_formulas_are_drawn_and_written_letter_by_letter(odd, tmp_path):
    table, (a, b, y) = log(400), odd
    names = {"a": a, "b": b, "y": y}
    renamed = Table({names.get(n, n): table[n] for n in table}, {names.get(n, n): table.unit(n) for n in table})
    fitted = fit_table(renamed, [a, b], [y], estimator=AbductiveRegressor(max_layers=1), edges={a: [0.0]})
    card = write_card(fitted, tmp_path / "card.html")
    assert card["models"][0]["inputs"] == [f"{a} [m]", b]
    page = (tmp_path / "card.html").read_text()
    assert all(escape(name) in page for name in (a, b, f"{y} [bar]"))
    assert page.count("data:image/svg+xml") == 3


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        (["a"], "<p>How many rows lie where.</p>"),
        (["a", "b"], "for every pair of inputs:"),
        (["a", "b", "c", "d", "e", "f"], "for every pair of the first 5 of 6 inputs:"),
    ],
)
def test_the_picture_of_rows_says_what_it_shows(inputs, words):
    rng = np.random.default_rng(1)
    assert words in _coverage_of(inputs, Table({name: rng.uniform(size=50) for name in inputs}, {}))


def test_a_card_says_that_inputs_do_not_determine_an_output(tmp_path):
    rng = np.random.default_rng(2)
    noise = Table({name: rng.uniform(size=40) for name in "aby"}, {})
    card = write_card(fit_table(noise, ["a", "b"], ["y"]), tmp_path / "card.html")
    (said,) = card["warnings"]
    assert said.startswith("y: these inputs do not determine it")
    assert escape(said) in (tmp_path / "card.html").read_text()


def test_a_card_ends_in_html(found, tmp_path):
    with pytest.raises(InputError, match="a model card ends in .html"):
        write_card(found, tmp_path / "card.pdf")


def test_a_model_holds_on_more_of_the_same_and_not_on_something_else(fits, tmp_path):
    save_models([fits[0].model], tmp_path / "m.json")
    (model,) = load_models(tmp_path / "m.json")
    same = validity(model, log(seed=1))
    assert same.holds
    assert same.covered == pytest.approx(0.9, abs=0.06)
    assert "as good as it was" in same.statements[0]
    worn = validity(model, log(scale=0.9, seed=1))
    assert not worn.holds
    assert "it errs more than it did" in worn.statements[0]
    assert "no longer hold" in worn.statements[1]
    wider = validity(model, log(reach=1.5, seed=1))
    assert wider.outside > 0.3
    assert any("outside its domain" in statement for statement in wider.statements)
    positive = log(seed=1)
    half = Table({name: values[positive["a"] > 0.0] for name, values in positive.columns.items()}, positive.units)
    assert any("no rows in 1 of its 2 regions" in statement for statement in validity(model, half).statements)


def test_other_units_and_missing_columns_are_named(fits):
    table = log()
    with pytest.raises(InputError, match="column 'a' is in 'in'; the model was fitted in 'm'"):
        validity(fits[0].model, Table(table.columns, {**table.units, "a": "in"}))
    with pytest.raises(InputError, match="no column 'b'"):
        validity(fits[0].model, Table({"a": table["a"], "y": table["y"]}, {"a": "m", "y": "Pa"}))
