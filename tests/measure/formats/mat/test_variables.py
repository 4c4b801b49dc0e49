"""Variables of MAT files, next to what SciPy lists."""

import numpy as np
import pytest
from scipy.io import savemat, whosmat
from scipy.sparse import eye_array

from helpers.mat_made import opaque
from polydraulic.errors import InputError
from polydraulic.measure.formats.mat.variables import MatVariable, variables_of

cells = np.empty((1, 2), dtype=object)
cells[0, 0], cells[0, 1] = np.arange(3.0), "word"
ITEMS = {
    "t": np.arange(9.0), "a_rather_long_name_of_a_matrix": np.zeros((4, 3)), "u": np.uint16([[1]]), "c": cells, "s": {"x": 1.0}, "w": "word",
    "i64": np.int64([1, 2]), "one": np.float32(2.0), "sparse": eye_array(5), "cube": np.zeros((2, 3, 4)), "z": 1j * np.ones(3), "e": np.zeros((0, 3)),
}  # fmt: skip


@pytest.mark.parametrize("compressed", [False, True])
def test_they_are_those_that_scipy_lists(tmp_path, compressed):
    savemat(tmp_path / "a.mat", ITEMS, do_compression=compressed)
    ours, theirs = [v[:3] for v in variables_of(tmp_path / "a.mat")], whosmat(tmp_path / "a.mat")
    assert [v if v[2] != "char" else v[::2] for v in ours] == [
        v if v[2] != "char" else v[::2] for v in theirs
    ]  # texts count as one
    with (tmp_path / "a.mat").open("ab") as file:
        file.write(
            opaque("rig", "timetable", compressed=compressed) + opaque("", "FileWrapper__", compressed=not compressed)
        )
    assert variables_of(tmp_path / "a.mat")[-2:] == [
        MatVariable("rig", (1,), "opaque", "timetable"),
        MatVariable("", (1,), "opaque", "FileWrapper__"),
    ]


def test_files_of_v4_are_listed_by_scipy(tmp_path):
    savemat(tmp_path / "a.mat", {"t": np.arange(9.0)}, format="4")
    assert variables_of(tmp_path / "a.mat") == [MatVariable("t", (1, 9), "double")]


def test_a_file_that_is_cut_off_is_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"t": np.arange(999.0)})
    (tmp_path / "a.mat").write_bytes((tmp_path / "a.mat").read_bytes()[:4000])
    with pytest.raises(InputError, match="it is cut off after 4000 bytes"):
        variables_of(tmp_path / "a.mat")
