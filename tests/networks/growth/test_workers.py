import math
import os
import signal
import warnings
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, current_thread

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from helpers.worker_tasks import end_this_process, warned
from polydraulic.errors import InputError
from polydraulic.networks.growth.workers import in_processes, in_threads, one_after_the_other, one_blas_thread


def blas_threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_results_come_in_the_order_of_the_items_whatever_works_on_them(monkeypatch):
    items = list(range(12))
    assert in_threads(math.sqrt, items) == [math.sqrt(item) for item in items]
    threads = set()
    monkeypatch.setattr("joblib.cpu_count", lambda: 1)
    assert in_threads(lambda item: threads.add(current_thread().name) or -item, items) == [-item for item in items]
    assert threads == {current_thread().name}


def test_processes_give_what_one_after_the_other_gives_and_tell_how_many_are_done():
    told, told_here = [], []
    assert in_processes(math.sqrt, [4.0, 9.0, 16.0], told.append) == [2.0, 3.0, 4.0]
    assert one_after_the_other(math.sqrt, [4.0, 9.0, 16.0], told_here.append) == [2.0, 3.0, 4.0]
    assert told == told_here == [0, 1, 2, 3]


@pytest.mark.skipif(os.name != "posix", reason="ends a process by a signal")
def test_a_process_that_is_ended_from_outside_is_one_error_that_says_what_to_do():
    with pytest.raises(InputError, match=r"memory ran out.*LOKY_MAX_CPU_COUNT=1"):
        in_processes(end_this_process, [signal.SIGKILL, signal.SIGKILL], lambda done: None)
    assert in_processes(math.sqrt, [4.0, 9.0], lambda done: None) == [2.0, 3.0]  # others take their place


def test_warnings_of_processes_are_the_callers_to_hear_or_to_refuse():
    with pytest.warns(UserWarning, match="item") as heard:
        assert in_processes(warned, [1, 2], lambda done: None) == [1, 2]
    assert {str(warning.message) for warning in heard} == {"item 1", "item 2"}
    with warnings.catch_warnings(), pytest.raises(UserWarning, match="item 1"):
        warnings.simplefilter("error")
        in_processes(warned, [1, 2], lambda done: None)


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
