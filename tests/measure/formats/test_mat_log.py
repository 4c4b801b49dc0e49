import numpy as np

from polydraulic.measure import open_log
from polydraulic.measure.findings import Findings


def test_matrices_are_signals_by_column(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"X": np.arange(20.0).reshape(2, 10), "y": np.arange(10.0)})
    with open_log(tmp_path / "a.mat") as log:
        assert [s.name for s in log.signals] == ["X[1]", "X[2]", "y"]
        (block,) = log.read(0, ["X[2]"], None, Findings())
    assert np.array_equal(block.values["X[2]"], np.arange(10.0, 20.0))
