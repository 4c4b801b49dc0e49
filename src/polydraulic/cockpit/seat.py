"""One page drives, others watch: who may say what, and what becomes of it."""

from typing import Any

from polydraulic.cockpit.beat import Beat
from polydraulic.cockpit.protocol import N_AXES, Message
from polydraulic.errors import InputError

PATIENCE = 10.0  # s of silence after which another page may drive


class Seat:
    """The driver's seat.

    Attributes
    ----------
    beat : Beat
        Whose wishes are replaced.
    pages : set of int
        Numbers of the pages that are open.
    driver : int
        0 if nobody drives.
    """

    def __init__(self, beat: Beat) -> None:
        self.beat = beat
        self.pages: set[int] = set()
        self.driver, self._last, self._heard = 0, 0, 0.0

    def enter(self) -> int:
        """Number of another page."""
        self._last += 1
        self.pages.add(self._last)
        return self._last

    def leave(self, page: int) -> None:
        """A page has gone; if it drove, levers are released and the machine is locked."""
        self.pages.discard(page)
        if page == self.driver:
            self.driver = 0
            self._release()

    def hear(self, page: int, message: Message) -> None:
        """Let a message of a page have its effect.

        Raises
        ------
        InputError
            What cannot be, or is not for this page to say.
        """
        kind, fields = message
        now = self.beat.clock()
        if kind == "drive":
            if self.driver not in (0, page) and now - self._heard <= PATIENCE:
                raise InputError("another page drives; this one watches")
            if self.driver != page:
                self._release()
            self.driver, self._heard = page, now
            return
        if page != self.driver:
            raise InputError("this page watches; ask to drive first")
        self._heard = now
        wanted = self.beat.wanted
        if kind == "sticks":
            self._want(seq=fields["seq"], axes=fields["axes"], heard=now)
        elif kind == "lock":
            self._want(locked=fields["on"], axes=(0.0,) * N_AXES)
        elif kind == "mode":
            if fields["mode"] == "coordinated":
                raise InputError("coordinated control is not there yet; levers move joints")
            self._want(mode=fields["mode"], pattern=fields["pattern"])
        elif kind == "reset":
            self._want(resets=wanted.resets + 1, payload=0.0, locked=True, axes=(0.0,) * N_AXES)
        elif kind == "payload":
            self._want(payload=fields["mass"])
        else:
            raise InputError(f"{kind}: is not there")

    def status(self, page: int) -> dict[str, Any]:
        """What a page is told when it changes."""
        wanted, shown = self.beat.wanted, self.beat.cab.shown
        driver = "nobody" if not self.driver else "you" if self.driver == page else "other"
        return {
            "type": "status",
            "driver": driver,
            "locked": wanted.locked,
            "mode": wanted.mode,
            "pattern": wanted.pattern,
            "recording": None,
            "recordings": [],
            "faults": [],
            "exercise": None,
            "replay": None,
            "payload": wanted.payload,
            "rate": round(shown.rate, 2),
            "error": shown.error,
        }

    def _release(self) -> None:
        self._want(locked=True, axes=(0.0,) * N_AXES)

    def _want(self, **changes: Any) -> None:
        self.beat.wanted = self.beat.wanted._replace(**changes)
