"""Every format gives the same numbers, block by block."""

import gzip
import re

import numpy as np
import pytest

from helpers.logs_made import MAP, UNITS, healthy, write_csv
from polydraulic.errors import InputError
from polydraulic.measure import import_log, load_channels, open_log, suggest_channels
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import BLOCK
from polydraulic.tables import read_table

FORMATS = ["csv", "csv.gz", "semicolon.csv", "latin.csv", "units.csv", "parquet", "mf4", "v5.mat", "v73.mat"]


def write(path, columns):
    name = path.name.partition(".")[2]
    if name == "csv":
        write_csv(path, columns)
    elif name == "csv.gz":
        plain = write_csv(path.with_name("plain.csv"), columns)
        path.write_bytes(gzip.compress(plain.read_bytes()))
    elif name == "semicolon.csv":
        write_csv(path, columns)
        path.write_text(path.read_text().replace(",", ";").replace(".", ","))
    elif name == "latin.csv":
        write_csv(path, columns)
        path.write_bytes(path.read_text().replace("speed", "spéed").encode("latin-1"))
    elif name == "units.csv":
        write_csv(path, columns, names=list(columns))
        header, _, rest = path.read_text().partition("\n")
        path.write_text(f"{header}\n{','.join(UNITS.values())}\n{rest}")
    elif name == "parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        fields = [pa.field(n, pa.float64(), metadata={"unit": UNITS[n]}) for n in columns]
        arrays = [pa.array(c, from_pandas=True) for c in columns.values()]
        pq.write_table(pa.table(arrays, schema=pa.schema(fields)), path)
    elif name == "mf4":
        from asammdf import MDF, Signal

        time = columns["time"]
        with MDF(version="4.10") as file:
            file.append([Signal(columns[n], time, UNITS[n], n) for n in ("lever", "p_head")], common_timebase=True)
            there = np.isfinite(columns["speed"])
            file.append([Signal(columns["speed"][there], time[there], UNITS["speed"], "speed")])
            file.save(path)
    elif name == "v5.mat":
        from scipy.io import savemat

        savemat(path, {"time": columns["time"], "log": {"lever": columns["lever"]}, "p_head": columns["p_head"][:, None],
                       "speed": columns["speed"], "text": "a word", "one": 5.0})  # fmt: skip
    else:
        import h5py

        with h5py.File(path, "w", userblock_size=512) as file:
            file["time"], file["p_head"] = columns["time"][None, :], columns["p_head"][None, :]
            file["log/lever"], file["speed"] = columns["lever"][None, :], columns["speed"][:, None]
            file["one"], file["text"] = 5.0, np.zeros((1, 3), dtype=np.uint16)
            file["text"].attrs["MATLAB_class"] = b"char"
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file")
    return path


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("expected")
    return table_of(write(folder / "log.csv", healthy()), folder)


def table_of(log, folder):
    text = MAP
    if log.suffix == ".mat":
        text = text.replace('source = "lever"', 'source = "log.lever"\nname = "lever"')
    if "latin" in log.name:
        text = text.replace('source = "speed"', 'source = "spéed"\nname = "speed"')
    (folder / "map.toml").write_text(text)
    found = import_log(log, load_channels(folder / "map.toml"), folder / "table.parquet")
    assert [str(f) for f in found.findings] == []
    return read_table(folder / "table.parquet")


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format_gives_the_same_table(tmp_path, expected, ending):
    found = table_of(write(tmp_path / f"log.{ending}", healthy()), tmp_path)
    assert found.names == ["time", "segment", "lever", "boom.p_a", "speed"]
    assert [found.unit(name) for name in found.names] == ["s", "1", "V", "Pa", "m/s"]
    for name in found.names:
        assert found[name] == pytest.approx(expected[name], rel=1e-12, abs=1e-12), name
    assert expected["boom.p_a"][:3] == pytest.approx(1e5 * healthy()["p_head"][:3])


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format_suggests_a_map_that_works(tmp_path, ending):
    log = write(tmp_path / f"log.{ending}", healthy())
    text = suggest_channels(log)
    (tmp_path / "map.toml").write_text(text)
    found = import_log(log, load_channels(tmp_path / "map.toml"), tmp_path / "t.csv")
    assert [str(f) for f in found.findings] == []
    assert found.n_row == 3999
    if ".mat" not in ending:
        assert text.count('unit = "bar"') == 1
    assert 'raster = "20 ms"' in text


@pytest.mark.parametrize("ending", ["csv", "parquet", "mf4", "v73.mat"])
def test_blocks_follow_each_other(tmp_path, ending):
    n = 4 * BLOCK if ending == "mf4" else BLOCK + BLOCK // 2
    columns = healthy(n=n)
    with open_log(write(tmp_path / f"log.{ending}", columns)) as log:
        group = log.signal("p_head").group
        blocks = list(log.read(group, ["p_head"], None if log.own_clock else "time", Findings()))
    assert len(blocks) == (1 if ending == "csv" else 2)  # the CSV has less than 4 MB
    assert np.array_equal(np.concatenate([b.rows for b in blocks]), np.arange(1, n + 1))
    assert np.array_equal(np.concatenate([b.values["p_head"] for b in blocks]), columns["p_head"])
    assert blocks[-1].done == 1.0


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.xls", b"x", "a log ends in one of .*; save the sheet as .csv"),
        ("a.lvm", b"x", "a text of columns is read as .csv"),
        ("a.h5", b"x", "HDF5 with a data set for each signal is read as .mat"),
        ("a.feather", b"x", "is written as .parquet by pyarrow"),
        ("a.trc", b"x", "frames of a CAN bus are read as .asc or .blf"),
        ("a.dat", b"MDF     3.30 nonsense", "cannot be read as an MDF log"),
        ("a.dat", b"\0\1\2", "cannot be read as an MDF log"),
        ("a.dat", b"", "cannot be read as an MDF log"),
        ("a.csv", b"", "the file is empty"),
        ("a.csv", b"time,a\n", "the log has no rows"),
        ("a.csv", b"# logger", "the log has no rows"),
        ("a.csv", b"a\0b,c\n", "is not text"),
        ("a.csv", b"\x1f\x8b\x08\0\0", r"is not text; .*: it is packed by gzip: call it \.csv\.gz"),
        ("a.csv", b"PK\x03\x04\0\0", "is not text; .*: it is a workbook or an archive"),
        ("a.csv", b"PAR1\x15\x04", r"is not text; .*: it is Parquet: call it \.parquet"),
        ("a.csv", b"MDF     3.30", r"is not text; .*: it is MDF: call it \.mf4"),
        ("a.csv.gz", b"time,a\n1,2\n", r"cannot be read \(damaged, or not packed .* call it \.csv if it is text"),
        ("a.csv.zip", b"x", "a log ends in one of .*; unpack it"),
        ("a.txt.gz", b"x", r"a log ends in one of .*; a text of columns that gzip packed is read as \.csv\.gz"),
        ("a.parquet", b"PAR1 nonsense", "cannot be read as a Parquet log"),
        ("a.mf4", b"nonsense", "cannot be read as an MDF log"),
        ("a.mat", b"nonsense", "cannot be read as a MAT log"),
        ("a.mat", b"MATLAB 7.3 nonsense", "cannot be read as a MAT log"),
    ],
)
def test_a_bad_file_is_one_error(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        open_log(tmp_path / name)


@pytest.mark.parametrize("head", ["PAR1,PAR2", "MDF x,time"])
def test_names_that_begin_as_other_files_do_are_names(tmp_path, head):
    (tmp_path / "a.csv").write_text(f"{head}\n" + "".join(f"{k},{k % 7}\n" for k in range(50)))
    with open_log(tmp_path / "a.csv") as log:
        assert [signal.name for signal in log.signals] == head.split(",")


@pytest.mark.parametrize("name", ["a.tsv", "a.dat", "A.DAT"])
def test_texts_of_columns_have_other_endings_too(tmp_path, name):
    head = (
        '"TOA5","CR1000"\n"TIMESTAMP","p"\n"TS","bar"\n"","Avg"\n' if "dat" in name.lower() else "TIMESTAMP\tp [bar]\n"
    )
    mark = "," if "dat" in name.lower() else "\t"
    (tmp_path / name).write_text(head + "".join(f'"2024-03-31 13:59:{k:02d}"{mark}{k % 7}\n' for k in range(50)))
    with open_log(tmp_path / name) as log:
        assert [(s.name, s.kind) for s in log.signals] == [("TIMESTAMP", "stamp"), ("p", "")]
        assert log.signal("p").unit == "bar"


def test_a_missing_file_or_channel_is_one_error(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        open_log(tmp_path / "a.csv")
    log = write_csv(tmp_path / "log.csv", healthy(n=100))
    (tmp_path / "map.toml").write_text(MAP.replace('source = "p_head"', 'source = "p_rod"'))
    with pytest.raises(InputError, match="no channel 'p_rod'; the log has"):
        import_log(log, load_channels(tmp_path / "map.toml"), tmp_path / "t.csv")
    (tmp_path / "map.toml").write_text(MAP.replace('role = "time"', 'role = "ignore"'))
    with pytest.raises(InputError, match="no channel with the role 'time'; name one, or give the interval"):
        import_log(log, load_channels(tmp_path / "map.toml"), tmp_path / "t.csv")


def test_rows_without_a_clock_take_the_interval_of_the_map(tmp_path):
    log = write_csv(tmp_path / "log.csv", healthy(n=400))
    text = MAP.replace('role = "time"', 'role = "ignore"').replace('"10 ms"\n', '"10 ms"\ninterval = "10 ms"\n', 1)
    (tmp_path / "map.toml").write_text(text)
    found = import_log(log, load_channels(tmp_path / "map.toml"), tmp_path / "t.csv")
    assert found.excerpt["time"] == pytest.approx(np.arange(399) * 0.01)
    assert len(found.findings) == 0


def test_parquet_columns_of_lists_are_left_out_by_name_and_fields_of_records_are_signals(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = tmp_path / "log.parquet"
    record = pa.array([{"a": 1.0, "b": {"c": 3, "d": [1]}}, None])
    parts = {"time": [0.0, 0.01], "p": [[1.0, 2.0], [3.0, 4.0]], "q": record, "r": [5.0, 6.0]}
    pq.write_table(pa.table(parts), path)
    log = open_log(path)
    assert [signal.name for signal in log.signals] == ["time", "q.a", "q.b.c", "r"]
    assert list(log.left_out) == ["p", "q.b.d"]
    for name in ("p", "p.x", "p[0]"):
        with pytest.raises(InputError, match=re.escape(f"channel '{name}' cannot be read: values of kind list<")):
            log.signal(name)
    with pytest.raises(InputError, match="no channel 'pq'"):
        log.signal("pq")
    (block,) = log.read(0, ["q.b.c", "r", "q.a"], "time", Findings())
    assert block.values["q.b.c"].tolist()[0] == 3.0
    assert np.isnan([block.values[name][1] for name in ("q.a", "q.b.c")]).all()
    assert block.values["r"].tolist() == [5.0, 6.0]


def test_a_folder_of_parquet_files_is_told_from_a_bag(tmp_path):
    (tmp_path / "log.parquet").mkdir()
    (tmp_path / "log.parquet" / "part-0.parquet").write_bytes(b"x")
    with pytest.raises(InputError, match=r"a folder of Parquet files: give these, as in '.*\*\.parquet'"):
        open_log(tmp_path / "log.parquet")
