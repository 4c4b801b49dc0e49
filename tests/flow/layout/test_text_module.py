"""Texts as modules: run only as they were written, with or without a place to keep them."""

import inspect
import subprocess
import sys
from pathlib import Path

from polydraulic.flow.layout import text_module
from polydraulic.flow.layout.text_module import loaded

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
