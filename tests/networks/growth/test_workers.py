import math
from threading import current_thread

import numpy as np
from threadpoolctl import threadpool_info

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


def test_blas_keeps_to_one_thread_and_gets_its_own_back():
    np.ones((2, 2)) @ np.ones((2, 2))
    before = blas_threads()
    with one_blas_thread():
        assert blas_threads() == {1}
    assert blas_threads() == before
