"""Texts as modules: run only as they were written, with or without a place to keep them."""

import inspect
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from polydraulic import build_flow
from polydraulic.flow.layout import text_module
from polydraulic.flow.layout.text_module import kept_text, loaded, written_name
from polydraulic.simulation.layout.prepare import prepare_layout

TEXT = '"""A text."""\n\n\ndef answer():\n    return {number}\n'


def test_a_text_is_a_file_whose_source_can_be_seen():
    found = loaded(TEXT.format(number=42))
    assert found.answer() == 42
    assert inspect.getsource(found.answer) == "def answer():\n    return 42\n"
    assert loaded(TEXT.format(number=42)) is found
    assert loaded(TEXT.format(number=43)) is not found


def test_a_file_that_somebody_changed_is_written_anew(monkeypatch, tmp_path):
    monkeypatch.setattr(text_module, "cache_folder", lambda: str(tmp_path))
    loaded(TEXT.format(number=44))
    (path,) = tmp_path.glob("*.py")
    path.write_text(TEXT.format(number=45), encoding="utf-8")
    text_module.loaded.cache_clear()
    assert loaded(TEXT.format(number=44)).answer() == 44
    assert path.read_text(encoding="utf-8") == TEXT.format(number=44)


def test_without_a_place_the_text_lives_in_memory(monkeypatch, caplog, tmp_path):
    monkeypatch.setattr(text_module, "cache_folder", lambda: None)
    found = loaded(TEXT.format(number=46))
    assert found.answer() == 46
    assert not Path(found.__file__).exists()
    assert inspect.getsource(found.answer).endswith("return 46\n")
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    monkeypatch.setattr(text_module, "cache_folder", lambda: str(blocked))
    assert loaded(TEXT.format(number=47)).answer() == 47
    assert "compiled anew" in caplog.text


def test_two_processes_may_write_at_once(tmp_path):
    code = f"from polydraulic.flow.layout.text_module import loaded\nprint(loaded({TEXT.format(number=48)!r}).answer())"
    running = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert [process.communicate(timeout=120)[0].strip() for process in running] == ["48", "48"]


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
def test_the_compiler_tells_named_tuples_of_two_texts_apart_at_once(machine):
    """It looks at names of classes and fields alone, and at every number in Python where those do not settle the type."""
    from numba._dispatcher import compute_fingerprint

    plants = [prepare_layout(machine, 5e-3, flow=build_flow(name, machine)).plant for name in ("exact", "polynomial")]
    assert type(plants[0]) is not type(plants[1])
    assert plants[0] == plants[1]
    assert compute_fingerprint(plants[0]) != compute_fingerprint(plants[1])
    assert {written_name(type(plant)) for plant in plants} == {"Plant"}


def test_a_text_is_written_once_and_a_damaged_file_counts_for_nothing(monkeypatch, caplog, tmp_path):
    monkeypatch.setattr(text_module, "cache_folder", lambda: str(tmp_path))
    written = []

    def write():
        written.append(1)
        return TEXT.format(number=49)

    assert kept_text("a key", write) == kept_text("a key", write) == TEXT.format(number=49)
    assert len(written) == 1
    assert kept_text("another", lambda: "other\n") == "other\n"
    (path,) = [path for path in tmp_path.glob("text_*.txt") if "answer" in path.read_text(encoding="utf-8")]
    path.write_text(path.read_text(encoding="utf-8").replace("49", "50"), encoding="utf-8")
    assert kept_text("a key", write) == TEXT.format(number=49)
    assert len(written) == 2
    assert "50" not in path.read_text(encoding="utf-8")
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    monkeypatch.setattr(text_module, "cache_folder", lambda: str(blocked))
    assert kept_text("a key", write) == TEXT.format(number=49)
    assert "written anew in each run" in caplog.text
