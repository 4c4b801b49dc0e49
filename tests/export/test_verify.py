"""The agreement report, and that it finds what is wrong."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from helpers.running_joints import joints
from polydraulic.errors import InputError
from polydraulic.export import agreement_table, build, fresh, targets, verify, verify_models
from polydraulic.networks import Model


def test_all_targets_agree(exported_models):
    found, not_tried = verify_models(exported_models["several"], n=300)
    targets = {a.target for a in found}
    assert targets == {
        "python", "c double", "c float", "fmi2 me", "fmi2 cs", "fmi3 me", "fmi3 cs", "onnx double", "onnx float",
    }  # fmt: skip
    assert len(found) == 3 * len(targets)
    assert all(a.holds for a in found)
    for a in found:
        if a.target.startswith(("c double", "fmi", "python")):
            assert (a.inside, a.border, a.outside) == (0.0, 0.0, 0.0)
        if not a.exact:
            assert 0.0 < a.inside < 1e-4 * a.size
        if a.target == "c float":
            assert 0.01 < a.used <= 1.0
            assert a.inside <= a.allowance
            assert a.domain == 0  # borders are those of double precision
        else:
            assert (a.allowance, a.used) == (None, None)
    table = agreement_table(found, not_tried)
    assert table.count("of the proved allowance of") == 3
    assert "fmi3 cs: out put [bar]" in table
    assert "fmi3 cs: out put [Pa]" in agreement_table(found, not_tried, "si")
    assert "not tried: sympy, latex" in table
    assert "DIFFERS" not in table
    assert table.splitlines()[-1] == (
        "verified: python, c double, c float, fmi2 me, fmi2 cs, fmi3 me, fmi3 cs, onnx double give what the package gives, "
        "c float within what is proved of it"
    )


def test_models_that_run_are_compared_row_by_row():
    found, not_tried = verify_models(joints(), n=30)
    rows = {a.target for a in found if a.target.endswith(" run")}
    assert rows == {"c run", "fmi2 run", "fmi3 run"}
    assert not any(a.target.startswith("fmi") for a in found if a.target not in rows)
    assert all(
        (a.inside, a.border, a.outside, a.slopes, a.domain) == (0.0, None, None, None, None)
        for a in found
        if a.target in rows
    )
    assert all(a.holds for a in found)
    assert agreement_table(found, not_tried).splitlines()[2 + len(found) - 1].split()[-5:] == ["0", "-", "-", "-", "-"]
    without = {a.target for a in verify_models(joints(raster=None), n=30)[0]}
    assert {"c run", "fmi3 me", "fmi3 cs"} <= without
    assert "fmi3 run" not in without


def test_a_run_that_differs_is_told(monkeypatch):
    right = fresh.run_texts

    def wrong(*given):
        return {
            name: text.replace("last + limits.up)", "last + 0.5 * limits.up)") for name, text in right(*given).items()
        }

    monkeypatch.setattr(fresh, "run_texts", wrong)
    found, _ = verify_models(joints(), n=30)
    assert {a.target for a in found if not a.holds} == {"c run"}
    monkeypatch.setattr(
        fresh, "run_texts", lambda *given: {name: text + "oh no" for name, text in right(*given).items()}
    )
    found, not_tried = verify_models(joints(), n=30)
    assert not_tried["c run"].startswith("fails: ")
    assert {(a.target, a.inside) for a in found if not a.holds} == {("c run", np.inf)}


def test_differences_are_shown_in_the_unit_of_the_output_and_borders_that_round_are_no_fault():
    agreement = verify.Agreement("onnx float", "p [Pa]", 2e4, 3e4, 0.0, None, 7, 2e7, False, unit="Pa", rounded=7)
    lines = agreement_table([agreement], {}).splitlines()
    assert lines[2].split() == ["onnx", "float:", "p", "[bar]", "0.2", "0.3", "0", "-", "7", "rounded"]
    assert lines[3].endswith("as at 7 of the points, which all lie on borders: no fault of it")
    assert lines[4] == "verified: nothing could be judged here"
    elsewhere = agreement_table([agreement._replace(rounded=6)], {}).splitlines()
    assert elsewhere[2].endswith("7 differ")
    assert elsewhere[3].endswith("it may answer for the other side")
    others = [agreement._replace(target="c float"), agreement._replace(domain=0, rounded=0)]
    assert agreement_table(others, {}).splitlines()[4].endswith("it may answer for the other side")
    assert agreement_table([agreement], {}, "si").splitlines()[2].split()[2:5] == ["p", "[Pa]", "2e+04"]


def test_the_verdict_counts_its_targets():
    right = verify.Agreement("python", "p", 0.0, 0.0, 0.0, 0.0, 0, 1.0, True)
    wrong = right._replace(inside=1.0)
    assert agreement_table([right], {}).endswith("verified: python gives what the package gives")
    assert agreement_table([wrong], {}).endswith("python does not give what the package gives")
    both = [wrong, wrong._replace(target="c double")]
    assert agreement_table(both, {}).endswith("verified: no: python, c double do not give what the package gives")


def test_a_wrong_number_is_told(exported_models, monkeypatch):
    right = targets.to_python

    def wrong(model: Model, name: str) -> str:
        network = model.networks[0]
        shifted = replace(network, y_mean=network.y_mean + 1e-6)
        return right(replace(model, networks=(shifted, *model.networks[1:])), name)

    monkeypatch.setattr(targets, "to_python", wrong)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    for module in (fresh, build):
        monkeypatch.setattr(module, "find_spec", lambda name: None)
    found, not_tried = verify_models(exported_models["single"], n=60)
    assert [a.target for a in found] == ["python"]
    assert not found[0].holds
    assert found[0].inside == pytest.approx(1e-6)
    assert agreement_table(found, not_tried).count("DIFFERS") == 1
    assert agreement_table(found, not_tried).endswith("verified: no: python does not give what the package gives")
    assert not_tried["c double"] == "no C compiler is installed"
    assert not_tried["fmi2 me"] == 'needs fmpy: pip install "polydraulic[verify]"'
    assert not_tried["onnx float"] == 'needs onnx: pip install "polydraulic[verify]"'


def test_single_precision_beyond_what_is_proved_is_told(exported_models, monkeypatch):
    right = fresh.to_c

    def wrong(whole, *, real, prove):
        (model,) = whole.models
        (network,) = model.networks
        shifted = replace(network, y_mean=network.y_mean + 1e-3)
        return right(replace(whole, models=(replace(model, networks=(shifted,)),)), real=real, prove=prove)

    monkeypatch.setattr(fresh, "to_c", wrong)
    targets_of = verify._targets
    monkeypatch.setattr(verify, "_targets", lambda *three: [one for one in targets_of(*three) if one[0] == "c float"])
    found, not_tried = verify_models(exported_models["single"], n=300)
    assert not found[0].holds
    assert found[0].used > 1.0
    assert agreement_table(found, not_tried).count("DIFFERS") == 1


def test_of_many_networks_nothing_is_proved_unless_asked_for(exported_models, monkeypatch):
    monkeypatch.setattr(verify, "PROVED", 1)
    targets_of = verify._targets
    monkeypatch.setattr(verify, "_targets", lambda *three: [one for one in targets_of(*three) if one[0] == "c float"])
    found, not_tried = verify_models(exported_models["regions"], n=60)
    assert (found[0].allowance, found[0].used) == (None, None)
    assert "of 6 networks it takes long" in agreement_table(found, not_tried)
    found, not_tried = verify_models(exported_models["regions"], n=60, prove=True)
    assert 0.0 < found[0].used <= 1.0
    assert "proof of c float" not in not_tried


def test_what_gives_no_number_differs_infinitely(exported_models, monkeypatch):
    monkeypatch.setattr(verify, "_targets", lambda whole, run, folder, prove: [
        ("nan", True, lambda X: fresh.Answers(np.full((len(X), 1), np.nan)))])  # fmt: skip
    found, _ = verify_models(exported_models["single"], n=60)
    assert found[0].inside == np.inf
    assert not found[0].holds


def test_too_few_points(exported_models):
    with pytest.raises(InputError, match="at least 6 points"):
        verify_models(exported_models["single"], n=3)
