import stat

import pytest

from polydraulic.errors import InputError
from polydraulic.files import replacing, write_text


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
