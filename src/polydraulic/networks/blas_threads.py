"""BLAS on one thread while something is learnt, whichever thread learns it, and its own number of threads again after that."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

from threadpoolctl import ThreadpoolController


@cache
def _libraries() -> ThreadpoolController:
    """Those of NumPy and SciPy: of one that is loaded later nothing would be known."""
    import scipy.linalg.blas  # noqa: F401

    return ThreadpoolController()


_limited = Lock()
# the thread that limits BLAS and what it has set, once for each context that is inside
_keepers: list[tuple[ThreadPoolExecutor, Any]] = []


def _limit() -> Any:
    return _libraries().limit(limits=1, user_api="blas").__enter__()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Context in which BLAS keeps to one thread: with matrices as small as here, several wait for each other more than they compute.

    How many threads share a product decides its last digits, so that the limit must hold in whichever thread a context is. Contexts
    of several threads may overlap: the first sets, the last gives back. A library that is limited for the whole process obeys the thread
    alone that has limited it first, until that gives back; hence a thread of its own for that, and the caller's limit for libraries that
    are limited thread by thread.
    """
    with _limited:
        if not _keepers:
            keeper = ThreadPoolExecutor(1)
            _keepers.append((keeper, keeper.submit(_limit).result()))
        else:
            _keepers.append(_keepers[0])
    try:
        with _libraries().limit(limits=1, user_api="blas"):
            yield
    finally:
        with _limited:
            keeper, limit = _keepers.pop()
            if not _keepers:
                keeper.submit(limit.__exit__, None, None, None).result()
                keeper.shutdown()
