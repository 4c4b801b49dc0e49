"""One page drives, others watch: who may say what, and what becomes of it."""

from collections.abc import Callable
from typing import Any

from polydraulic.cockpit.beat import Beat
from polydraulic.cockpit.cab import DT
from polydraulic.cockpit.keeper import Keeper
from polydraulic.cockpit.protocol import N_AXES, PageMessage
from polydraulic.cockpit.recorded.drives import ENDING, Drive, read_drive
from polydraulic.cockpit.wanted import ReplayWish, TrialWish
from polydraulic.errors import InputError, briefly

PATIENCE = 10.0  # s of silence after which another page may drive
_NEUTRAL = (0.0,) * N_AXES


class Seat:
    """The driver's seat.

    Attributes
    ----------
    beat : Beat
        Whose wishes are replaced.
    keeper : Keeper
    pages : set of int
        Numbers of the pages that are open.
    driver : int
        0 if nobody drives.
    """

    def __init__(self, beat: Beat, keeper: Keeper) -> None:
        self.beat, self.keeper = beat, keeper
        self.pages: set[int] = set()
        self.driver, self._last, self._heard, self._wishes = 0, 0, 0.0, 0
        self._says: dict[str, Callable[[dict[str, Any]], None]] = {
            "sticks": self._sticks,
            "lock": lambda fields: self._want(locked=fields["on"], axes=_NEUTRAL),
            "mode": self._mode,
            "guard": self._guard,
            "reset": self._reset,
            "payload": self._payload,
            "record": self._record,
            "fault": self._fault,
            "exercise": self._exercise,
            "replay": self._replay,
            "study": self._study,
        }

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
            self._want(locked=True, axes=_NEUTRAL)

    def hear(self, page: int, message: PageMessage) -> None:
        """Let a message of a page have its effect.

        Raises
        ------
        InputError
            What cannot be, or is not for this page to say.
        """
        now = self.beat.clock()
        if message.type == "drive":
            if self.driver not in (0, page) and now - self._heard <= PATIENCE:
                raise InputError("another page drives; this one watches")
            if self.driver != page:
                self._want(locked=True, axes=_NEUTRAL)
            self.driver, self._heard = page, now
            return
        if page != self.driver:
            raise InputError("this page watches; ask to drive first")
        self._heard = now
        self._says[message.type](message.fields)

    def status(self, page: int) -> dict[str, Any]:
        """What a page is told when it changes."""
        wanted, shown = self.beat.wanted, self.beat.cab.shown
        driver = "nobody" if not self.driver else "you" if self.driver == page else "other"
        replay, trial = shown.replay, wanted.trial
        return {
            "type": "status",
            "driver": driver,
            "locked": wanted.locked,
            "mode": wanted.mode,
            "pattern": wanted.pattern,
            "guard": wanted.guarded,
            "recording": self.keeper.recording,
            "recordings": list(self.keeper.drives),
            "faults": list(shown.faults),
            "exercise": None if trial is None else {"name": trial.name, "subject": trial.subject},
            "replay": None
            if replay is None
            else {"name": replay.name, "time": round(replay.time, 1), "end": replay.end, "playing": replay.playing},
            "payload": shown.payload,
            "rate": round(shown.rate, 2),
            "shadow": shown.shadow,
            "study": None if self.keeper.course is None else self.keeper.course.shown(),
        }

    def _sticks(self, fields: dict[str, Any]) -> None:
        self._want(seq=fields["seq"], axes=fields["axes"], heard=self.beat.clock())

    def _mode(self, fields: dict[str, Any]) -> None:
        self._freely("the mode")
        if fields["mode"] == "coordinated" and self.beat.cab.coordination is None:
            raise InputError(f"no coordinated control of this machine: {self.beat.cab.uncoordinated}")
        self._want(mode=fields["mode"], pattern=fields["pattern"], axes=_NEUTRAL)

    def _guard(self, fields: dict[str, Any]) -> None:
        self._freely("the guard against tipping")
        coordination = self.beat.cab.coordination
        why = self.beat.cab.uncoordinated if coordination is None else coordination.unguarded
        if fields["on"] and why:
            raise InputError(f"no guard against tipping for this machine: {why}")
        self._want(guarded=fields["on"])

    def _reset(self, fields: dict[str, Any]) -> None:
        self._by_hand("a reset")
        wanted = self.beat.wanted
        self._want(resets=wanted.resets + 1, payload=0.0, locked=True, axes=_NEUTRAL, trial=None)

    def _payload(self, fields: dict[str, Any]) -> None:
        self._by_hand("a payload")
        trial = self.beat.cab.shown.trial
        if trial is not None and trial.running:
            raise InputError("the exercise decides what hangs at the tip")
        most = self.beat.cab.most_payload
        if fields["mass"] > most:
            raise InputError(
                f"payload: mass = {fields['mass']:g} kg: at most {most:g} kg hang at the tip of this machine"
            )
        self._want(payload=fields["mass"])

    def _record(self, fields: dict[str, Any]) -> None:
        if fields["on"]:
            self._by_hand("a recording")
            if not self.beat.wanted.recording:
                self._want(recording=self._wish())
        else:
            self._want(recording=0)

    def _fault(self, fields: dict[str, Any]) -> None:
        self._by_hand("a fault")
        self._freely("faults")
        name, faults = fields["name"], self.beat.wanted.faults
        self._known(name, self.beat.cab.faults, "fault")
        self._want(faults=tuple(f for f in faults if f != name) + ((name,) if fields["on"] else ()))

    def _exercise(self, fields: dict[str, Any]) -> None:
        if fields["action"] == "stop":
            self._want(trial=None)
            return
        self._by_hand("an exercise")
        self._freely("exercises")
        self._known(fields["name"], self.beat.cab.exercises, "exercise")
        subject = fields.get("subject", "")
        if not all(c.isalnum() or c in "-_" for c in subject):
            raise InputError(
                f"subject = {briefly(subject)}: must be a code of letters, digits, - and _; nothing personal"
            )
        self._want(trial=TrialWish(self._wish(), fields["name"], subject), payload=0.0, axes=_NEUTRAL)

    def _study(self, fields: dict[str, Any]) -> None:
        course, action, text = self.keeper.course, fields["action"], fields.get("text", "")
        if course is None:
            raise InputError("there is no study: start the cockpit with --study FILE")
        trial = self.beat.cab.shown.trial
        if trial is not None and trial.running:
            raise InputError("an exercise is running; it ends first")
        if trial is not None and trial.number == course.wish:
            raise InputError("the last attempt is being written; a moment")
        if action == "subject":
            course.choose(text)
            self._want(locked=True, axes=_NEUTRAL, trial=None)
        elif action == "start":
            self._by_hand("an exercise")
            task, wish = course.wanted(), self._wish()
            course.begin(wish)
            wanted = TrialWish(wish, task.exercise, course.subject)
            self._want(
                mode=task.mode,
                pattern=course.study.pattern,
                guarded=False,
                trial=wanted,
                payload=0.0,
                faults=(),
                axes=_NEUTRAL,
            )
        else:
            self.keeper.tell(course.skip() if action == "skip" else course.answer(text))

    def _freely(self, what: str) -> None:
        course = self.keeper.course
        if course is not None and course.subject:
            raise InputError(f"the study prescribes {what}")

    def _replay(self, fields: dict[str, Any]) -> None:
        """All but to begin, which reads a file: see `drive_to_read`."""
        wish, action = self._replayed(), fields["action"]
        if wish is None:
            raise InputError("nothing is replayed; choose a recording and play it")
        if action in ("restart", "stop"):
            taken = self.beat.wanted.taken_over + (action == "restart")
            self._want(replay=None, taken_over=taken, locked=True, axes=_NEUTRAL, payload=self._payload_then(action))
        elif action == "seek":
            if "time" not in fields:
                raise InputError("replay: seek needs a time in s")
            step = min(round(min(fields["time"], 1e9) / DT), wish.drive.end)
            self._want(replay=wish._replace(seeks=wish.seeks + 1, step=step))
        else:
            self._want(replay=wish._replace(playing=action == "play"))

    def _payload_then(self, action: str) -> float:
        return self.beat.cab.shown.payload if action == "restart" else 0.0

    def drive_to_read(self, page: int, message: PageMessage) -> str | None:
        """Name of the drive that a message wants to be read, because another one, or none, is replayed."""
        wish = self._replayed()
        if message.type != "replay" or page != self.driver or message.fields["action"] not in ("play", "seek", "pause"):
            return None
        name = message.fields["name"]
        if wish is not None and wish.drive.name == name:
            return None
        self._known(name, self.keeper.drives, "recording")
        return str(name)

    def read(self, name: str) -> Drive:
        """Read a drive; takes a while.

        Raises
        ------
        InputError
        """
        drive, cab = read_drive(self.keeper.folder / f"{name}{ENDING}"), self.beat.cab
        if drive.head["functions"] != list(cab.simulator.names):
            raise InputError(f"the recording {name} is of {drive.head['machine']}, not of this machine")
        return drive

    def begin_replay(self, page: int, drive: Drive) -> None:
        """Let a drive be replayed from its beginning, if the page still drives."""
        if page != self.driver:
            raise InputError("another page drives by now")
        self._want(replay=ReplayWish(self._wish(), drive), recording=0, trial=None, locked=True, axes=_NEUTRAL)

    def _replayed(self) -> ReplayWish | None:
        """What is replayed, or about to be; not what the machine's thread has given up."""
        wish = self.beat.wanted.replay
        return None if wish is None or wish.number == self.beat.cab.given_up else wish

    def _by_hand(self, what: str) -> None:
        if self._replayed() is not None:
            raise InputError(f"{what} is not for a replay; restart from it, or stop it first")

    @staticmethod
    def _known(name: str, names: Any, what: str) -> None:
        if name not in names:
            raise InputError(f"there is no {what} {briefly(name)}; there are {list(names)}")

    def _wish(self) -> int:
        self._wishes += 1
        return self._wishes

    def _want(self, **changes: Any) -> None:
        self.beat.wanted = self.beat.wanted._replace(**changes)
