import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.mdf.formula import arithmetic

RAW = np.arange(1, 31, dtype=np.int16)
ENDINGS = [("4.10", "mf4"), ("3.30", "dat")]


@pytest.fixture
def evaluated(monkeypatch):
    """Texts that asammdf evaluates."""
    from asammdf.blocks import v2_v3_blocks, v4_blocks

    texts = []
    for module in (v4_blocks, v2_v3_blocks):
        monkeypatch.setattr(module, "evaluate", lambda text: texts.append(text) or 1 / 0)
        monkeypatch.setattr(module, "lambdify", None)
    return texts


def log_with(path, formula, version, time_formula=None, table=False):
    """Write a log of a channel with a formula beside one without; the formula may stand in a table, or be that of the time."""
    from asammdf import MDF, Signal
    from asammdf.blocks.conversion_utils import from_dict

    conversion = {"formula": formula if version > "4" else formula.replace("X1", "X")}  # of which asammdf makes X1
    if table:
        conversion = {"lower_0": 0, "upper_0": 100, "text_0": from_dict(conversion), "default_addr": b"error"}
    with MDF(version=version) as file:
        file.append(
            [Signal(RAW, RAW * 0.1, "bar", name, conversion=c) for name, c in (("p", conversion), ("q", None))],
            common_timebase=True,
        )
        if time_formula:
            master = file.groups[0].channels[0]
            master.conversion = from_dict({"formula": time_formula})
        return file.save(path).rename(path)


@pytest.mark.parametrize(("version", "ending"), ENDINGS)
def test_formulas_of_arithmetic_are_computed_by_us(tmp_path, evaluated, version, ending):
    path = log_with(tmp_path / f"a.{ending}", "X1*2", version)
    with open_log(path) as log:
        assert log.signal("p").unit == "bar"
        (block,) = log.read(log.signal("p").group, ["p", "q"], None, Findings())
    assert block.values["p"].tolist() == (2.0 * RAW).tolist()
    assert block.values["q"].tolist() == RAW.tolist()
    assert evaluated == []


@pytest.mark.parametrize(("version", "ending"), ENDINGS)
def test_channels_of_other_formulas_are_left_out_by_name(tmp_path, evaluated, version, ending):
    path = log_with(tmp_path / f"a.{ending}", "sqrt(X1)", version)
    with open_log(path) as log:
        assert [signal.name for signal in log.signals] == ["q"]
        assert "the formula 'sqrt(X1)'" in log.left_out["p"]
    assert evaluated == []


def test_a_table_that_holds_a_formula_is_left_out(tmp_path, evaluated):
    with open_log(log_with(tmp_path / "a.mf4", "X1*2", "4.10", table=True)) as log:
        assert "the formula 'X1*2'" in log.left_out["p"]
    assert evaluated == []


def test_a_time_that_is_a_formula_is_refused(tmp_path, evaluated):
    path = log_with(tmp_path / "a.mf4", "X1*2", "4.10", time_formula="X1*2")
    with pytest.raises(InputError, match="the time of group .* cannot be read: its conversion is the formula 'X1[*]2'"):
        open_log(path)
    assert evaluated == []


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("X1*2", 2.0 * RAW),
        (" X / 4 - 40.5", RAW / 4 - 40.5),
        ("-(X1 + 1e1) * (3 - X1)", -(RAW + 10.0) * (3.0 - RAW)),
        ("5", np.full(30, 5.0)),
        ("X1 / (X1 - 1)", np.concatenate([[np.inf], RAW[1:] / (RAW[1:] - 1.0)])),
    ],
)
def test_arithmetic(text, expected):
    assert arithmetic(text)(RAW.astype(float)).tolist() == expected.tolist()


@pytest.mark.parametrize(
    "text",
    ["", "Y", "X1**2", "X1^2", "sin(X1)", "X1.real", "[X1][0]", "X1 if X1 else 1", "'a'", "1j*X1", "True", "X1;1", "X2 + 1",
     "lambda: 1", "(" * 400 + "X1" + ")" * 400, "X1+" * 400 + "1", "9" * 400 + "*X1", "X1 @ X1", "X1 // 2", "x = 1", "\0"],
)  # fmt: skip
def test_what_is_no_arithmetic_is_no_function(text):
    assert arithmetic(text) is None
