"""Blocks that come one after the other: the next is made, and the last written, while this one is worked on."""

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")


def ahead(items: Iterator[T]) -> Iterator[T]:
    """The same items in the same order; while one is worked on, a thread makes the next. An error comes where its item would."""
    end = object()
    with ThreadPoolExecutor(1) as thread:
        coming: Future[Any] = thread.submit(next, items, end)
        while (item := coming.result()) is not end:
            coming = thread.submit(next, items, end)
            yield item


@contextmanager
def done_later(call: Callable[[T], object]) -> Iterator[Callable[[T], None]]:
    """A function that has `call` called in a thread, in order; it waits for the call before, and raises what that raised.

    At the end of the context all calls have been made.
    """
    with ThreadPoolExecutor(1) as thread:
        going: list[Future[object]] = []

        def later(item: T) -> None:
            if going:
                going.pop().result()
            going.append(thread.submit(call, item))

        yield later
        for last in going:
            last.result()
