import os
import re
import resource
import subprocess
import sys

import numba
import pytest
from numba.core.codegen import JITCodeLibrary, JitEngine

from polydraulic import _kernel, _kernel_cache
from polydraulic._kernel import driver, kernel
from polydraulic._kernel_cache import keep_compiled

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")


def doubled(x):
    return 2.0 * x


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """Compile `doubled` with a cache of its own, as a new process would."""
    monkeypatch.setattr(_kernel_cache, "_warned", False)

    def compiled(folder=tmp_path):
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(folder))
        made = numba.njit(doubled)
        keep_compiled(made, doubled)
        return made

    return compiled


def hits(compiled):
    return sum(compiled.stats.cache_hits.values())


def test_what_was_compiled_is_read_by_the_next_process(fresh, tmp_path):
    first, second = fresh(), fresh()
    assert first(2.0) == 4.0
    assert hits(first) == 0
    assert second(2.0) == 4.0
    assert hits(second) == 1
    assert second(3) == 6.0  # another signature is another file
    assert len(list(tmp_path.rglob("*.nbc"))) == 2
    assert [path.suffix for path in tmp_path.rglob("*") if path.is_file()] == [".nbc"] * 2


@pytest.mark.parametrize(
    "damage",
    [lambda b: b"", lambda b: b[:20], lambda b: b[: len(b) // 2], lambda b: b"\0" * len(b),
     lambda b: b[:-100] + bytes([b[-100] ^ 1]) + b[-99:], lambda b: b + b"x"],
)  # fmt: skip
def test_a_damaged_file_is_replaced(fresh, tmp_path, damage):
    fresh()(2.0)
    (path,) = tmp_path.rglob("*.nbc")
    sound = path.read_bytes()
    path.write_bytes(damage(sound))
    again = fresh()
    assert again(2.0) == 4.0
    assert hits(again) == 0
    (path,) = tmp_path.rglob("*.nbc")
    assert len(path.read_bytes()) > len(sound) // 2
    third = fresh()
    assert third(2.0) == 4.0
    assert hits(third) == 1


def test_a_file_of_another_state_is_not_read(fresh, tmp_path, monkeypatch):
    fresh()(2.0)
    (path,) = tmp_path.rglob("*.nbc")
    monkeypatch.setattr(numba, "__version__", "other")
    again = fresh()
    assert again(2.0) == 4.0
    assert hits(again) == 0
    (other,) = set(tmp_path.rglob("*.nbc")) - {path}
    other.write_bytes(path.read_bytes())  # sound, and of another version
    third = fresh()
    assert third(2.0) == 4.0
    assert hits(third) == 0


def test_a_full_disk_is_one_warning(fresh, tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    first, second = fresh(), fresh()
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        with pytest.warns(RuntimeWarning, match=r"cannot be kept in .* \(File too large\)") as warned:
            assert (first(2.0), first(3), second(2.0)) == (4.0, 6.0, 4.0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert len(warned) == 1
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_folder_that_cannot_be_made_is_one_warning(fresh, tmp_path):
    (tmp_path / "file").touch()
    compiled = fresh(tmp_path / "file")
    with pytest.warns(RuntimeWarning, match=r"cannot be kept in .*file.* \(Not a directory\).*NUMBA_CACHE_DIR"):
        assert compiled(2.0) == 4.0


def test_a_cache_that_cannot_be_written_can_be_read(fresh, tmp_path, monkeypatch):
    fresh()(2.0)

    def full(*arguments):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(_kernel_cache._Files, "save", full)
    compiled = fresh()
    assert compiled(2.0) == 4.0
    assert hits(compiled) == 1
    with pytest.warns(RuntimeWarning, match="Read-only file system"):
        assert compiled(3) == 6.0


@pytest.mark.parametrize("place", ["/dev/null", "/proc/none"])
def test_kernels_run_without_a_cache_and_say_so_in_one_line(place):
    code = "from polydraulic.elementary import sincos; print(sincos(0.0).cos)"
    run = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "NUMBA_CACHE_DIR": place}, capture_output=True, text=True
    )
    assert (run.returncode, run.stdout) == (0, "1.0\n")
    assert re.fullmatch(rf".*compiled functions cannot be kept in {place}/polydraulic/\w+ .*\n", run.stderr)


def third(x):
    return x / 3.0


def third_more(x):
    return third(x) + 1.0


@pytest.fixture
def nested(tmp_path, monkeypatch):
    """A kernel that calls another, as a new process would have them, with a cache of their own."""
    monkeypatch.setattr(_kernel, "_FOLDER", str(tmp_path))
    plain = third

    def made():
        monkeypatch.setitem(third_more.__globals__, "third", kernel(plain))
        return kernel(third_more)

    return made


def calling(inner):
    @driver
    def sum_of(x):
        return inner(x) + inner(2.0 * x)

    return sum_of


def test_only_a_caller_becomes_machine_code(nested, monkeypatch):
    made = []
    finalize = JitEngine.finalize_object
    monkeypatch.setattr(JitEngine, "finalize_object", lambda engine: made.append(engine) or finalize(engine))
    assert calling(nested())(6.0) == 8.0
    assert len(made) == 1


def test_kernels_on_disk_are_taken_in_by_another_caller(nested, monkeypatch, tmp_path):
    assert calling(nested())(6.0) == 8.0
    inner = nested()
    compiled = []
    add = JITCodeLibrary.add_ir_module
    monkeypatch.setattr(
        JITCodeLibrary, "add_ir_module", lambda library, module: compiled.append(library.name) or add(library, module)
    )

    @driver
    def difference_of(x):
        return inner(2.0 * x) - inner(x)

    assert difference_of(6.0) == 2.0
    assert {name.rpartition(".")[2] for name in compiled} == {"difference_of"}
    assert inner(6.0) == 3.0  # with a way in from Python, and machine code
    assert "third_more" in " ".join(compiled)
    assert len(list(tmp_path.rglob("*.third_more-*.nbc"))) == 2


def test_what_was_inlined_is_no_function_any_more(nested):
    def written_out(x):
        return (x / 3.0 + 1.0) + (2.0 * x / 3.0 + 1.0)

    taken_in = calling(nested())
    assert taken_in(1.7) == written_out(1.7)
    written = [line for line in taken_in.inspect_llvm((numba.float64,)).splitlines() if line.startswith("define")]
    assert not [line for line in written if "third" in line]
