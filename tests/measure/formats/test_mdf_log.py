import numpy as np
import pytest

from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings


def test_invalid_samples_of_an_mdf_are_missing(tmp_path):
    from asammdf import MDF, Signal

    time = np.arange(10) * 0.1
    with MDF(version="4.10") as file:
        file.append([Signal(time, time, "V", "a", invalidation_bits=np.arange(10) == 3)], common_timebase=True)
        file.save(tmp_path / "a.mf4")
    with open_log(tmp_path / "a.mf4") as log:
        (block,) = log.read(0, ["a"], None, Findings())
    assert np.flatnonzero(np.isnan(block.values["a"])).tolist() == [3]


def test_raw_numbers_and_texts_of_an_mdf(tmp_path):
    from asammdf import MDF, Signal

    time = np.arange(10) * 0.1
    linear = {"a": 2.0, "b": 5.0}
    names = {f"val_{k}": k for k in range(2)} | {f"text_{k}": name for k, name in enumerate((b"off", b"on"))}
    with MDF(version="4.10") as file:
        raw = np.arange(10, dtype=np.uint8)
        file.append([
            Signal(raw, time, "V", "scaled", conversion=linear),
            Signal(raw % 2, time, "", "state", conversion=names),
            Signal(np.array([b"x"] * 10), time, "", "words", encoding="utf-8"),
        ], common_timebase=True)  # fmt: skip
        file.save(tmp_path / "a.mf4")
    with open_log(tmp_path / "a.mf4") as log:
        (block,) = log.read(0, ["scaled", "state", "words"], None, Findings())
    assert block.time == pytest.approx(time)
    assert block.values["scaled"] == pytest.approx(2.0 * np.arange(10) + 5.0)
    assert block.values["state"].tolist() == [0, 1] * 5
    assert block.text["words"].tolist() == list(range(10))
    assert np.all(np.isnan(block.values["words"]))
