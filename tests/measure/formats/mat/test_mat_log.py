import numpy as np
import pytest

from helpers.mat_made import opaque
from polydraulic.errors import InputError
from polydraulic.measure import import_log, open_log, suggest_channels
from polydraulic.measure.channels import channel_map
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.mat.arrays import COMPLEX, SPARSE


def test_matrices_are_signals_by_column(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"X": np.arange(20.0).reshape(2, 10), "y": np.arange(10.0)})
    with open_log(tmp_path / "a.mat") as log:
        assert [s.name for s in log.signals] == ["X[1]", "X[2]", "y"]
        (block,) = log.read(0, ["X[2]"], None, Findings())
    assert np.array_equal(block.values["X[2]"], np.arange(10.0, 20.0))


@pytest.mark.parametrize("version", ["v5", "v73"])
def test_an_array_of_structures_of_one_number_each_is_a_table(tmp_path, version):
    """As ``table2struct`` makes one."""
    path, time, p = tmp_path / f"{version}.mat", np.arange(6) * 0.1, np.arange(100, 106)
    if version == "v5":
        from scipy.io import savemat

        kinds = [("time", object), ("p", object), ("note", object), ("pair", object)]
        rows = np.array([(t, v, "x", np.array([v, t])) for t, v in zip(time, p, strict=True)], dtype=kinds)
        savemat(path, {"s": rows[:, None]})
    else:
        import h5py

        with h5py.File(path, "w") as file:
            s, refs = file.create_group("s"), file.create_group("#refs#")
            s.attrs["MATLAB_class"] = b"struct"
            for key, values in (
                ("time", time[:, None, None]),
                ("p", p[:, None, None]),
                ("pair", np.column_stack([p, time])[:, None]),
            ):
                field = s.create_dataset(key, shape=(6, 1), dtype=h5py.ref_dtype)
                for k, value in enumerate(values):
                    refs[f"{key}{k}"] = value
                    refs[f"{key}{k}"].attrs["MATLAB_class"] = b"double"
                    field[k, 0] = refs[f"{key}{k}"].ref
    with open_log(path) as log:
        assert {s.name for s in log.signals} == {"s.time", "s.p", *(f"s[{k}].pair" for k in range(1, 7))}
        (block,) = log.read(log.signal("s.p").group, ["s.p"], "s.time", Findings())
    assert np.array_equal(block.time, time)
    assert np.array_equal(block.values["s.p"], p)


def structure_with_time(path, time, p, wide):
    """Simulink's structure with time: two signals, the second with one column for each of its elements."""
    if "v5" in path.name:
        from scipy.io import savemat

        signals = np.zeros((1, 2), dtype=[("values", object), ("label", object)])
        signals[0, 0], signals[0, 1] = (p[:, None], "p"), (wide, "wide")
        savemat(path, {"out": {"time": time[:, None], "signals": signals, "blockName": "model/Scope"}})
        return
    import h5py

    with h5py.File(path, "w") as file:
        out = file.create_group("out")
        out["time"] = time[None]
        out.attrs["MATLAB_class"] = b"struct"
        refs = file.create_group("#refs#")
        refs["a"], refs["b"] = p[None], wide.T
        for item in (out["time"], refs["a"], refs["b"]):
            item.attrs["MATLAB_class"] = b"double"
        values = out.create_group("signals").create_dataset("values", shape=(2, 1), dtype=h5py.ref_dtype)
        values[0, 0], values[1, 0] = refs["a"].ref, refs["b"].ref


@pytest.mark.parametrize("version", ["v5", "v73"])
def test_simulink_structures_with_time_are_read(tmp_path, version):
    time = np.arange(3) * 0.1
    p = 100.0 + time
    structure_with_time(tmp_path / f"{version}.mat", time, p, np.arange(15.0).reshape(3, 5))  # wider than long
    with open_log(tmp_path / f"{version}.mat") as log:
        wide = [f"out.signals[2].values[{k}]" for k in range(1, 6)]
        assert {s.name for s in log.signals} == {"out.time", "out.signals[1].values", *wide}
        group = log.signal("out.time").group
        (block,) = log.read(group, ["out.signals[1].values", *wide], "out.time", Findings())
    assert np.array_equal(block.time, time)
    assert np.array_equal(block.values["out.signals[1].values"], p)
    assert 'source = "out.time"\nrole = "time"\nunit = "s"' in suggest_channels(tmp_path / f"{version}.mat")
    for k in range(5):
        assert np.array_equal(block.values[wide[k]], np.arange(3) * 5.0 + k)


@pytest.mark.parametrize("version", ["v5", "v73"])
def test_signals_that_are_matrices_have_time_as_their_last_side(tmp_path, version):
    cube = np.arange(2 * 3 * 7.0).reshape(2, 3, 7)
    path = tmp_path / "a.mat"
    if version == "v5":
        from scipy.io import savemat

        savemat(path, {"out": {"time": np.arange(7.0), "signals": {"values": cube}}, "loose": cube})
    else:
        import h5py

        with h5py.File(path, "w") as file:
            file["out/time"], file["out/signals/values"], file["loose"] = np.arange(7.0)[None], cube.T, cube.T
    with open_log(path) as log:
        (block,) = log.read(0, [f"out.signals.values[{k}]" for k in range(1, 7)], "out.time", Findings())
        assert log.left_out == {"loose": "an array of more than two dimensions: save matrices of it, as p = a(:, :, 1)"}
    for k in range(6):  # MATLAB counts down the columns
        assert np.array_equal(block.values[f"out.signals.values[{k + 1}]"], cube[k % 2, k // 2])


def test_what_is_no_array_is_named_in_v7_3(tmp_path):
    import h5py

    with h5py.File(tmp_path / "a.mat", "w") as file:
        file["t"], file["p"] = np.arange(9.0)[None], np.arange(9.0)[None]
        file["empty"] = np.array([0, 0], dtype=np.uint64)
        file["empty"].attrs["MATLAB_empty"], file["empty"].attrs["MATLAB_class"] = np.uint8(1), b"double"
        for name, values in (("data", np.ones(9)), ("ir", np.arange(9)), ("jc", np.arange(10))):
            file[f"sparse/{name}"] = values
        file["sparse"].attrs["MATLAB_sparse"], file["sparse"].attrs["MATLAB_class"] = np.uint64(9), b"double"
        for kind in ("timetable", "string"):
            file[kind] = np.array([[0xDD000000, 2, 1, 1, 1, 1]], dtype=np.uint32)
            file[kind].attrs["MATLAB_class"], file[kind].attrs["MATLAB_object_decode"] = kind.encode(), np.int32(3)
        file["complex"] = np.ones((1, 9), dtype=[("real", "f8"), ("imag", "f8")])
        file["#subsystem#/MCOS"] = np.arange(50.0)[None]
    with open_log(tmp_path / "a.mat") as log:
        assert [s.name for s in log.signals] == ["p", "t"]
        reasons = log.left_out
        with pytest.raises(
            InputError, match=r"channel 'timetable' cannot be read: an object of class timetable: writetimetable\(tt,"
        ):
            log.signal("timetable")
    assert reasons["empty"] == "an empty array"
    assert reasons["sparse"] == "a sparse matrix: save p = full(p)"
    assert reasons["string"] == "an object of class string"
    assert reasons["complex"] == "complex numbers: save real(z) or abs(z)"
    assert len(reasons) == 5


@pytest.mark.parametrize("compressed", [False, True])
def test_objects_are_named_with_what_to_do_in_v5(tmp_path, compressed):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"t": np.arange(9.0), "p": np.arange(9.0)}, do_compression=compressed)
    with (tmp_path / "a.mat").open("ab") as file:
        for name, kind in (("rig", "timetable"), ("words", "string"), ("ts", "timeseries")):
            file.write(opaque(name, kind, compressed=compressed))
    with open_log(tmp_path / "a.mat") as log:
        assert [s.name for s in log.signals] == ["t", "p"]
        assert set(log.left_out) == {"rig", "words", "ts"}
        assert log.left_out["words"] == "an object of class string"
        with pytest.raises(
            InputError, match=r"channel 'rig' cannot be read: an object of class timetable: writetimetable\(tt"
        ):
            log.signal("rig")
    alone = tmp_path / "b.mat"
    alone.write_bytes((tmp_path / "a.mat").read_bytes()[:128] + opaque("rig", "timetable", compressed=compressed))
    with pytest.raises(InputError, match=r"b.mat: .*'rig' \(an object of class timetable: writetimetable"):
        open_log(alone)


def test_what_is_no_array_is_named_in_v5(tmp_path):
    from scipy.io import savemat
    from scipy.sparse import eye_array

    cells = np.empty((1, 2), dtype=object)
    cells[0, 0], cells[0, 1] = np.arange(3.0), "word"
    savemat(tmp_path / "a.mat", {"t": np.arange(9.0), "empty": np.zeros((0, 3)), "sparse": eye_array(9), "cells": cells,
                                 "text": "a word", "part": {"empty": np.zeros(0), "z": np.ones(9) * 1j}})  # fmt: skip
    with open_log(tmp_path / "a.mat") as log:
        assert [s.name for s in log.signals] == ["t"]
        assert log.left_out == {"empty": "an empty array", "sparse": SPARSE, "cells": "a cell array: save what is in it, as p = c{1}",
                                "part.empty": "an empty array", "part.z": COMPLEX}  # fmt: skip


def test_the_report_of_an_import_names_what_was_not_read(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"t": np.arange(90.0) * 0.01, "p": np.sin(np.arange(90.0)), "empty": np.zeros((0, 3))})
    channels = [{"source": "t", "role": "time", "unit": "s"}, {"source": "p", "role": "input", "unit": "bar"}]
    found = import_log(tmp_path / "a.mat", channel_map({"raster": "10 ms", "channel": channels}), tmp_path / "t.csv")
    (finding,) = found.findings.of("not read")
    assert finding.detail == "'empty' (an empty array)"
    assert "# Not read: 'empty' (an empty array)" in suggest_channels(tmp_path / "a.mat")


@pytest.mark.parametrize("version", ["v5", "v73"])
def test_a_damaged_file_is_one_error_or_what_is_left_of_it(tmp_path, version):
    """A file cut anywhere, or with bytes changed in its head, is read or refused, never a traceback."""
    path = tmp_path / "a.mat"
    structure_with_time(tmp_path / f"{version}.mat", np.arange(40.0), np.arange(40.0), np.ones((40, 2)))
    whole = (tmp_path / f"{version}.mat").read_bytes()
    refused = 0
    for end in range(0, len(whole), max(1, len(whole) // 40)):
        path.write_bytes(whole[:end])
        try:
            with open_log(path) as log:
                for signal in log.signals:
                    list(log.read(signal.group, [signal.name], None, Findings()))
        except InputError as error:
            refused += str(path) in str(error)
    assert refused >= 20


def test_structures_that_hold_themselves_come_to_an_end(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "b.mat", "w") as file:
        s = file.create_group("s")
        s["p"] = np.arange(9.0)[None]
        for name in ("a", "b", "c"):
            s[name] = s
        refs = s.create_dataset("runs", shape=(2, 1), dtype=h5py.ref_dtype)
        refs[:, 0] = [refs.ref, refs.ref]
    with open_log(tmp_path / "b.mat") as log:
        assert [signal.name for signal in log.signals] == ["s.p"]
        assert set(log.left_out.values()) == {"the same as another structure"}
        assert {"s.a", "s.b", "s.c"} < set(log.left_out)
