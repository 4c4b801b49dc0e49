"""The schedule, by a clock of its own: what is due is made, what is too late is given up and counted, silence releases the levers."""

from polydraulic.cockpit.beat import MOST_AT_ONCE, Beat
from polydraulic.cockpit.cab import DT
from polydraulic.cockpit.protocol import SILENCE
from polydraulic.cockpit.wanted import CabShown, Wanted


class Moved:
    """A cab that notes what is asked of it."""

    def __init__(self):
        self.moves = []
        self.shown = CabShown()

    def move(self, wanted, n, *, overruns, rate):
        self.moves.append((n, wanted.axes, overruns, rate))


class Hands:
    """A clock that is set by hand."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def begun():
    clock = Hands()
    beat = Beat(Moved(), clock=clock)
    beat.begin()
    return beat, clock


def test_a_delay_is_made_up_for_and_no_step_is_made_twice():
    beat, clock = begun()
    for now in (0.001, 0.0052, 0.0071, 0.0223, 0.0251):
        clock.now = 100.0 + now
        left = beat.beat()
        assert 0.0 < left <= DT + 1e-9
    assert [n for n, *_ in beat.cab.moves] == [1, 3, 1]
    assert beat.overruns == 0


def test_what_is_too_late_is_given_up_and_counted():
    beat, clock = begun()
    clock.now += 1.0 + 1e-6
    beat.beat()
    clock.now += DT
    beat.beat()
    assert [(n, overruns) for n, _, overruns, _ in beat.cab.moves] == [
        (MOST_AT_ONCE, 200 - MOST_AT_ONCE),
        (1, 200 - MOST_AT_ONCE),
    ]
    assert beat.made + beat.overruns == 201


def test_levers_are_released_when_nothing_is_heard():
    beat, clock = begun()
    axes = (0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    beat.wanted = Wanted(axes=axes, heard=clock.now, locked=False)
    clock.now += SILENCE - DT
    beat.beat()
    clock.now += 3.0 * DT
    beat.beat()
    assert [moved for _, moved, *_ in beat.cab.moves] == [axes, (0.0,) * 6]


def test_a_thread_moves_the_machine_at_the_pace_of_the_clock():
    import time

    beat = Beat(Moved())
    beat.start()
    time.sleep(0.2)
    beat.stop()
    assert beat.failed is None
    assert beat.made + beat.overruns >= 35  # of 40, on a busy computer
    seen = len(beat.cab.moves)
    time.sleep(0.02)
    assert len(beat.cab.moves) == seen


def test_what_ends_the_thread_is_kept():
    class Broken(Moved):
        def move(self, *args, **more):
            raise ZeroDivisionError

    beat = Beat(Broken())
    beat.start()
    beat._thread.join(5.0)
    assert isinstance(beat.failed, ZeroDivisionError)
