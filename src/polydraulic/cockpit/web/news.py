"""What a page has not been told yet."""

from typing import Any

from polydraulic.cockpit.wanted import CabShown
from polydraulic.cockpit.web.seat import Seat

_EVERY = 6  # frames between two scores


class News:
    """Texts for one page, each when something has changed.

    Parameters
    ----------
    seat : Seat
    page : int
    """

    def __init__(self, seat: Seat, page: int) -> None:
        self._seat, self._page = seat, page
        self._status: dict[str, Any] | None = None
        shown = seat.beat.cab.shown
        self._event = shown.events[-1][0] if shown.events else 0
        self._errors = (shown.error[0], seat.keeper.error[0])
        self._score: dict[str, Any] | None = None
        self._count = 0

    def of(self, shown: CabShown) -> list[dict[str, Any]]:
        """Texts that are to be sent with this snapshot."""
        found: list[dict[str, Any]] = []
        events = [event for number, event in shown.events if number > self._event]
        if events:
            self._event = shown.events[-1][0]
            found.append({"type": "events", "events": events})
        for place, (number, text) in enumerate((shown.error, self._seat.keeper.error)):
            if number != self._errors[place]:
                found.append({"type": "error", "text": text})
        self._errors = (shown.error[0], self._seat.keeper.error[0])
        status = self._seat.status(self._page)
        if status != self._status:
            self._status = status
            found.append(status)
        self._count += 1
        if shown.trial is not None and (self._count % _EVERY == 0 or not shown.trial.running):
            trial = shown.trial
            score = {
                "type": "score",
                "exercise": trial.exercise,
                "subject": trial.subject,
                "running": trial.running,
                "finished": trial.finished,
                "values": trial.score,
            }
            if score != self._score:
                self._score = score
                found.append(score)
        return found
