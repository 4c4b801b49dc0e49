"""Work side by side: pieces that know nothing of each other, in threads or in processes.

Results do not depend on the number of workers: each piece is computed as if it were alone.
"""

import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError
from joblib.parallel import get_active_backend

from polydraulic.errors import InputError

A = TypeVar("A")
B = TypeVar("B")
_Warning = tuple[str, type[Warning], str, int]  # message, category, file, line
_said: dict[str | tuple[str, type[Warning], int], int] = {}  # as Python keeps it, so that each is shown once


def in_threads(call: Callable[[A], B], items: Iterable[A]) -> list[B]:
    """Results of a call for each item, in their order: for work in compiled code and BLAS, which let other threads run.

    Parameters
    ----------
    call : function of an item
    items : iterable
    """
    work = list(items)
    n_worker = min(joblib.cpu_count(), len(work))
    if n_worker < 2:
        return [call(item) for item in work]
    with ThreadPoolExecutor(n_worker) as pool:
        return list(pool.map(call, work))


def in_processes(call: Callable[[A], B], items: Iterable[A], told: Callable[[int], object]) -> list[B]:
    """Results of a call for each item, in their order: for long work in Python, which pays for processes that start.

    Parameters
    ----------
    call : function of an item
        Of a module, as other processes find it.
    items : iterable
        Sent to them.
    told : function of int
        Told how many are done, from none on, in the caller's thread.

    Raises
    ------
    InputError
        If one of the processes is ended from outside, as a system does that runs out of memory.
    """
    work = list(items)
    n_worker = min(joblib.cpu_count(), len(work))
    if n_worker < 2 or get_active_backend()[0].nesting_level:  # in a process that is a worker itself
        return one_after_the_other(call, work, told)
    with joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        results = joblib.Parallel(n_jobs=n_worker, return_as="generator")(
            joblib.delayed(_heard)(call, item) for item in work
        )
    try:
        found = one_after_the_other(lambda result: result, results, told)
    except TerminatedWorkerError as error:
        raise InputError(
            f"one of {n_worker} processes that learnt side by side was ended from outside, most likely since memory ran out; nothing was "
            "kept: learn from fewer rows, or in one process, by the environment variable LOKY_MAX_CPU_COUNT=1"
        ) from error
    for message, category, file, line in (warning for _, heard in found for warning in heard):
        # after all: one may be raised as an error
        warnings.warn_explicit(message, category, file, line, registry=_said)
    return [result for result, _ in found]


def _heard(call: Callable[[A], B], item: A) -> tuple[B, list[_Warning]]:
    """Result of a call, and its warnings, of which the caller's process is to decide."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = call(item)
    return found, [(str(w.message), w.category, w.filename, w.lineno) for w in heard]


def one_after_the_other(call: Callable[[A], B], items: Iterable[A], told: Callable[[int], object]) -> list[B]:
    """The same in the caller's process."""
    found = list[B]()
    told(0)
    for item in items:
        found.append(call(item))
        told(len(found))
    return found
