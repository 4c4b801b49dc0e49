"""Work in a thread of its own: nothing is lost, changes its order, or fails unseen."""

import threading

import pytest

from polydraulic.ahead import ahead, done_later


def test_items_come_in_order_and_one_ahead():
    made = []

    def items():
        for n in range(5):
            made.append((n, threading.current_thread()))
            yield n

    assert list(ahead(items())) == [0, 1, 2, 3, 4]
    assert all(thread is not threading.main_thread() for _, thread in made)
    first = ahead(items())
    assert next(first) == 0
    first.close()
    assert len(made) <= 5 + 2  # no more than one beyond what was taken


def test_an_error_comes_where_its_item_would():
    def items():
        yield 1
        raise OSError("gone")

    found = ahead(items())
    assert next(found) == 1
    with pytest.raises(OSError, match="gone"):
        next(found)


def test_calls_are_made_in_order_before_the_context_ends():
    done = []
    with done_later(done.append) as later:
        for n in range(50):
            later(n)
    assert done == list(range(50))


def test_an_error_of_a_call_is_raised_by_the_next_or_at_the_end():
    def fail(n):
        raise OSError(f"no room for {n}")

    with pytest.raises(OSError, match="no room for 1"), done_later(fail) as later:
        later(1)
    with pytest.raises(OSError, match="no room for 1"), done_later(fail) as later:
        later(1)
        later(2)
