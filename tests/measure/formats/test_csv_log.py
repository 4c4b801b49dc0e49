import numpy as np
import pytest

from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings


def test_dates_are_times(tmp_path):
    (tmp_path / "a.csv").write_text("t,a\n2024-01-01 12:00:00.000,1\n2024-01-01 12:00:00.010,2\n")
    with open_log(tmp_path / "a.csv") as log:
        (block,) = log.read(0, ["a"], "t", Findings())
    assert np.diff(block.time) == pytest.approx([0.01], rel=1e-4)
