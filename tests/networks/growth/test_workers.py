import math
import os
import signal
import warnings
from threading import current_thread

import pytest

from helpers.worker_tasks import end_this_process, warned
from polydraulic.errors import InputError
from polydraulic.networks.growth.workers import in_processes, in_threads, one_after_the_other


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
