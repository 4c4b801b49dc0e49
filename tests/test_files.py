import ast
import os
import re
import resource
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.files import Scratch, check_apart, check_writable, replacing, write_text, write_texts
from polydraulic.tables import Table, read_table, write_table

SOURCES = Path(__file__).parents[1] / "src" / "polydraulic"


@contextmanager
def nearly_full(size=4096):
    """Files beyond a size cannot be written: the fault of a full disk, by another name."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_file_is_replaced_as_a_whole_and_its_folder_made(tmp_path):
    path = tmp_path / "a" / "b.txt"
    write_text(path, "öne")
    write_text(path, "twö")
    assert path.read_text(encoding="utf-8") == "twö"
    assert [found.name for found in path.parent.iterdir()] == ["b.txt"]


def test_what_fails_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "b.txt"
    write_text(path, "old")
    with pytest.raises(ZeroDivisionError), replacing(path) as temporary:
        temporary.write_text("half")
        assert path.read_text() == "old"
        _ = 1 / 0
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_file_can_be_read_by_those_who_may_read_others(tmp_path):
    write_text(tmp_path / "ours", "")
    (tmp_path / "theirs").touch()
    ours, theirs = (stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("ours", "theirs"))
    assert ours == theirs


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot write .*b.txt: "):
        write_text(tmp_path / "file" / "b.txt", "")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="cannot write .*folder: "):
        write_text(tmp_path / "folder", "")
    assert sorted(found.name for found in tmp_path.iterdir()) == ["file", "folder"]


def test_files_that_belong_together_are_all_new_or_all_old(tmp_path):
    header, source = tmp_path / "a.h", tmp_path / "a.c"
    write_texts({header: "old", source: "old"})
    with nearly_full(), pytest.raises(InputError, match="cannot write .*a.c: File too large"):
        write_texts({header: "new", source: "new" * 4096})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.h": "old", "a.c": "old"}
    write_texts({header: "new", source: "new"})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.h": "new", "a.c": "new"}


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_table_on_a_full_disk_leaves_the_old_one(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    write_table(Table({"x": np.arange(3.0)}, {}), path)
    with nearly_full(), pytest.raises(InputError, match="cannot write .*a.*File too large"):
        write_table(Table({"x": np.random.default_rng(1).normal(size=10_000)}, {}), path)
    assert read_table(path)["x"].tolist() == [0.0, 1.0, 2.0]
    assert list(tmp_path.iterdir()) == [path]


def test_what_killed_processes_left_is_removed_by_the_next_and_nothing_else(tmp_path):
    killed = f"""
import os, signal
from polydraulic.files import Scratch, replacing
with replacing({str(tmp_path / "b.txt")!r}) as temporary:
    temporary.write_text("half")
    scratch = Scratch()
    (scratch.folder / "some").write_text("rows")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    there = tmp_path / "tmp"
    there.mkdir()
    with replacing(tmp_path / "other.txt") as temporary:  # another process that is alive, as far as locks know
        assert subprocess.run([sys.executable, "-c", killed], env={**os.environ, "TMPDIR": str(there)}).returncode == -9
        assert {path.name for path in tmp_path.iterdir()} > {"tmp", temporary.name}
        assert len(list(tmp_path.iterdir())) == 3
        kept = tmp_path / ".b.txt.unfinished"
        kept.touch()
        write_text(tmp_path / "c.txt", "")
        assert {path.name for path in tmp_path.iterdir()} == {"tmp", temporary.name, kept.name, "c.txt"}
        temporary.write_text("whole")
    assert (tmp_path / "other.txt").read_text() == "whole"
    assert len(list(there.iterdir())) == 1
    ended = "from polydraulic.files import Scratch; Scratch().close()"
    subprocess.run([sys.executable, "-c", ended], env={**os.environ, "TMPDIR": str(there)}, check=True)
    assert list(there.iterdir()) == []


def test_devices_are_not_replaced_and_links_are_followed(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="cannot write .*pipe: it is no file"):
        write_text(tmp_path / "pipe", "")
    (tmp_path / "far").mkdir()
    (tmp_path / "link.txt").symlink_to(tmp_path / "far" / "real.txt")
    write_text(tmp_path / "link.txt", "x")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "far" / "real.txt").read_text() == "x"


def test_long_names_can_be_written(tmp_path):
    path = tmp_path / ("é" * 120 + ".txt")
    write_text(path, "x")
    assert path.read_text() == "x"


def test_many_processes_write_one_file_whole(tmp_path):
    code = f"""
from polydraulic.files import write_text
for _ in range(40):
    write_text({str(tmp_path / "a.txt")!r}, MINE * 5000)
"""
    writers = [subprocess.Popen([sys.executable, "-c", f"MINE = {mine!r}{code}"]) for mine in "abc"]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    assert (tmp_path / "a.txt").read_text() in {mine * 5000 for mine in "abc"}
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_folder_for_temporary_files_that_is_full_is_named():
    scratch = Scratch()
    with (
        nearly_full(),
        pytest.raises(InputError, match="cannot write temporary files to .*; the environment variable TMPDIR"),
        scratch.writing(),
    ):
        np.zeros(10_000).tofile(scratch.folder / "0")
    scratch.close()
    scratch.close()
    assert not scratch.folder.exists()


# Where sources write to a path that was given to them, or to a temporary folder: all else goes through `files`.
WRITERS = {
    "files.py": {"write_texts"},
    "tables.py": {"table_writer"},  # rows of a writer that is open
    "export/build.py": {"_compiled", "compile_program"},
    "export/fresh.py": {"_interpreted", "run_c", "run_c_rows"},
    "export/fresh_script.py": {"main"},
    "measure/formats/mat/v5.py": {"_array"},
    "measure/formats/can/can_log.py": {"flush"},
    "measure/formats/ros/topic_rows.py": {"flush"},
    "measure/bench/recording.py": {"_write_csv", "_write_parquet", "_write_mdf"},
}
SAVING = {"tofile", "savefig", "write_table", "save", "savez", "to_csv", "to_parquet"}


def places(call):
    """Expressions that may say where a call writes a file; none if it writes none."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    of = [call.func.value] if isinstance(call.func, ast.Attribute) else []
    texts = [a.value for a in call.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
    if name == "open" and any(re.fullmatch(r"[rwaxbt+]*[wax+][rwaxbt+]*", mode) for mode in texts):
        return of or call.args[:1]
    if name in ("write_text", "write_bytes"):  # bare names are our own, as of write_table
        return of
    return call.args[:2] if name in ("ZipFile", "ParquetWriter") or (of and name in SAVING) else []


def test_what_is_written_replaces_nothing_that_is_read(tmp_path):
    there, other = tmp_path / "log.csv", tmp_path / "other.csv"
    there.write_text("1")
    (tmp_path / "link.csv").symlink_to(there)
    for same in (there, str(there), tmp_path / "link.csv", tmp_path / "." / "log.csv"):
        with pytest.raises(InputError, match=r"\.csv: is the file that is read, which would be replaced"):
            check_apart(same, [other, there])
    check_apart(other, [there])
    check_apart(there, [])
    check_apart(there, ["task", "random:1:60"])  # names of what is no file


def test_a_place_that_can_be_written_stays_as_it_is(tmp_path):
    there = tmp_path / "log.csv"
    there.write_text("1")
    check_writable(there)
    check_writable(tmp_path / "new.csv")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("log.csv", "1")]
    for wrong, words in (
        (tmp_path, "it is a folder"),
        (there / "a.csv", "choose a folder"),
        (tmp_path / ("a" * 300), "name"),
    ):
        with pytest.raises(InputError, match=words):
            check_writable(wrong)


def test_every_file_is_written_in_one_way():
    found = {}
    for path in SOURCES.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                calls = [places(call) for call in ast.walk(node) if isinstance(call, ast.Call)]
                where = [{ast.unparse(place) for place in call} for call in calls if call]
                if not all(place & {"temporary", "stream", "text"} for place in where):  # the latter are in memory
                    found.setdefault(path.relative_to(SOURCES).as_posix(), set()).add(node.name)
    assert found == WRITERS
