import re
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from polydraulic import _kernel


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
def test_a_kernel_that_allocates_does_not_compile():
    @_kernel.kernel
    def allocates(n):
        return np.zeros(n).sum()

    with pytest.raises(numba.errors.NumbaError, match="No implementation|NRT"):
        allocates(3)


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
def test_a_kernel_that_is_inlined_is_compiled_without_a_way_in_from_python():
    @_kernel.kernel
    def half(x):
        return 0.5 * x

    @_kernel.driver
    def quarter(x):
        return half(half(x))

    assert quarter(4.0) == 1.0
    assert not half.signatures  # nothing that Python could call
    inlined = half.get_overload((numba.float64,))
    assert half(4.0) == 2.0
    assert half.signatures == [(numba.float64,)]
    assert half.get_overload((numba.float64,)) is inlined  # callers have theirs still
    written = [line for line in quarter.inspect_llvm((numba.float64,)).splitlines() if line.startswith("define")]
    assert not [line for line in written if "half" in line]


def test_all_kernels_are_in_the_digest():
    """numba sees an edit in the file of a kernel, not in those that it calls."""
    package = Path(_kernel.__file__).parent
    paths = {path.relative_to(package) for path in package.rglob("*.py")}
    found = {p for p in paths if re.search(r"^@(kernel|driver)\b", (package / p).read_text(), re.MULTILINE)}
    assert Path("machine/hose.py") in found
    assert not {p for p in found if p.parts[0] not in (*_kernel._COMPILED, "elementary.py")}


def test_the_digest_follows_every_source_of_kernels(tmp_path):
    package = Path(_kernel.__file__).parent
    copy = tmp_path / "polydraulic"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))

    def digest():
        code = "from polydraulic._kernel import source_digest; print(source_digest())"
        run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
        return run.stdout.strip()

    before = digest()
    assert before == _kernel.source_digest()
    with (copy / "machine" / "valve.py").open("a") as file:
        file.write("# edited\n")
    edited = digest()
    assert edited != before
    with (copy / "cli" / "app.py").open("a") as file:
        file.write("# edited\n")
    assert digest() == edited
    with (copy / "simulation" / "layout" / "pages" / "step.py.txt").open("a") as file:
        file.write("# edited\n")
    assert digest() not in (before, edited)


def test_other_packages_keep_their_cache_folder():
    before = numba.config.CACHE_DIR
    _kernel.driver(lambda x: x)
    assert before == numba.config.CACHE_DIR


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is kept in plain Python")
def test_a_warm_run_imports_neither_pandas_nor_what_only_compiling_needs(tmp_path):
    code = (
        "import sys; from polydraulic import simulate; from polydraulic.tables import write_table; "
        "write_table(simulate('cat215b', 'exact', 'task', t_end=0.05), sys.argv[1]); "
        "print([name for name in ('pandas', 'scipy.linalg') if name in sys.modules])"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "run.parquet")]
    for _ in range(2):
        run = subprocess.run(command, capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


@_kernel.kernel
def twice(x):
    return 2.0 * x


@_kernel.kernel
def twice_more(x):
    return twice(x) + 1.0


def test_a_kernel_in_plain_python_leaves_the_compiler_alone():
    plain = _kernel.in_plain_python(twice_more)
    assert plain(2.0) == twice_more(2.0) == 5.0
    if not numba.config.DISABLE_JIT:
        before = len(twice_more.signatures), len(twice.signatures)
        assert plain(np.float32(2.0)) == 5.0
        assert before == (len(twice_more.signatures), len(twice.signatures))
    assert _kernel.in_plain_python(len) is len
