import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
from threadpoolctl import threadpool_info

from polydraulic.networks.blas_threads import one_blas_thread


def blas_threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_blas_keeps_to_one_thread_and_gets_its_own_back():
    np.ones((2, 2)) @ np.ones((2, 2))
    before = blas_threads()
    with one_blas_thread():
        assert blas_threads() == {1}
    assert blas_threads() == before


def test_contexts_that_overlap_leave_blas_as_it_was():
    np.ones((2, 2)) @ np.ones((2, 2))
    before, one, other = blas_threads(), one_blas_thread(), one_blas_thread()
    one.__enter__()
    other.__enter__()
    one.__exit__(None, None, None)
    assert blas_threads() == {1}
    other.__exit__(None, None, None)
    assert blas_threads() == before


def test_the_limit_holds_in_every_thread_until_the_last_context_ends():
    """Also after another thread, which is still there, was the first to set it."""
    np.ones((2, 2)) @ np.ones((2, 2))
    before, both = blas_threads(), Barrier(2, timeout=60.0)
    with one_blas_thread():
        pass

    def inside(leaves_first):
        found = []
        with one_blas_thread():
            both.wait()
            found.append(blas_threads())
            if not leaves_first:
                both.wait()
                found.append(blas_threads())
        if leaves_first:
            both.wait()
        return found

    for _ in range(3):
        with ThreadPoolExecutor(2) as pool:
            assert list(pool.map(inside, [True, False])) == [[{1}], [{1}, {1}]]
        assert blas_threads() == before


LATE = """
from polydraulic.networks.blas_threads import one_blas_thread
with one_blas_thread():
    pass
import scipy.linalg.blas
from threadpoolctl import threadpool_info
with one_blas_thread():
    print({library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"})
"""


def test_a_library_that_is_used_later_is_limited_too():
    done = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True, check=True)
    assert done.stdout == "{1}\n"
