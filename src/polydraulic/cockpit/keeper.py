"""What is kept on disk while people drive: recorded drives, block by block, and results. The machine never waits for it."""

import asyncio
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from polydraulic.cockpit.beat import Beat
from polydraulic.cockpit.exercises.results import NAME, add_result, compared_attempts, read_results
from polydraulic.cockpit.recorded.drives import DriveFile, drive_names, new_name
from polydraulic.cockpit.study.course import Course
from polydraulic.cockpit.study.plan import Study
from polydraulic.cockpit.study.table import write_study_table
from polydraulic.errors import InputError

_PERIOD = 0.2  # s


class Keeper:
    """Writes what the machine's thread shows.

    Parameters
    ----------
    beat : Beat
    folder : Path
        Made when something is first kept.
    say : function (line)
        Tells the terminal what is lost.
    study : Study, optional
        Goes on from where the results in the folder end.

    Attributes
    ----------
    drives : tuple of str
        Names of the drives in the folder.
    recording : str or None
        Name of the one that is written.
    error : (number, text)
        The last thing that could not be written.
    course : Course or None
        Of the study.

    Raises
    ------
    OSError
        Results of a study that cannot be read.
    """

    def __init__(self, beat: Beat, folder: Path, say: Any, study: Study | None = None) -> None:
        self._beat, self.folder, self._say = beat, folder, say
        self.course = None if study is None else Course(study, read_results(folder))
        self._told: list[dict[str, Any]] = []  # of a study, what is no attempt
        self._file: DriveFile | None = None
        self._number, self._trial = 0, 0
        self.recording: str | None = None
        self.error = (0, "")
        self.drives: tuple[str, ...] = tuple(drive_names(folder))
        self.results: list[dict[str, Any]] = []

    async def run(self) -> None:
        """Look again and again, until cancelled; then write what is left."""
        try:
            while True:
                await asyncio.sleep(_PERIOD)
                await asyncio.to_thread(self.look)
        finally:
            self.look()
            self._close()

    def look(self) -> None:
        """Write what is new."""
        shown = self._beat.cab.shown
        taped, trial = shown.taped, shown.trial
        if taped is not None and taped.number != self._number:
            self._close()
            self._number = taped.number
            self._keep(self._open)
        if taped is not None and self._file is not None:
            file = self._file
            if self._keep(lambda: file.write(taped.first, taped.blocks)) and taped.ended:
                self._close()
        if trial is not None and not trial.running and trial.number != self._trial:
            self._trial = trial.number
            result = {
                "when": _now(),
                "subject": trial.subject,
                "machine": self._beat.cab.name,
                "flow": self._beat.cab.flow,
                "exercise": trial.exercise,
                "mode": trial.mode,
                "pattern": trial.pattern,
                "guard": trial.guarded,
                "faults": list(shown.faults),
                "finished": trial.finished,
                "values": {name: list(pair) for name, pair in trial.score.items()},
            }
            of = None if self.course is None else self.course.ended(trial.number, trial.finished)
            self._result(result if of is None else result | {"study": of})
        while self._told:
            self._result(self._told.pop(0))

    def tell(self, of: dict[str, Any]) -> None:
        """Keep what a study is told besides attempts: a task that is left out, an answer."""
        assert self.course is not None
        study = self.course.study
        self._told.append(
            {
                "when": _now(),
                "subject": self.course.subject,
                "machine": self._beat.cab.name,
                "flow": self._beat.cab.flow,
                "pattern": study.pattern,
                "finished": False,
                "values": {},
                "study": of,
            }
        )

    def _result(self, result: dict[str, Any]) -> None:
        """Write a result, and the table of the study that it belongs to."""
        self._keep(lambda: add_result(self.folder, result), what="the result")
        if self.course is not None and "study" in result:
            study = self.course.study
            self._keep(
                lambda: write_study_table(study, read_results(self.folder), self.folder), what="the table of the study"
            )

    def compared_results(self) -> dict[str, Any]:
        """``/results.json``: all attempts, and those that were finished compared by exercise and mode.

        Raises
        ------
        OSError
        """
        results = read_results(self.folder)
        return {"file": NAME, "attempts": results, "compared": compared_attempts(results)}

    def _open(self) -> None:
        name = new_name(self.folder, self._beat.cab.name)
        self._file = DriveFile(self.folder, name)
        self.recording = name

    def _close(self) -> None:
        if self._file is not None:
            self._file.close()
            self.drives = tuple(drive_names(self.folder))
        self._file, self.recording = None, None

    def _keep(self, write: Any, what: str = "the recording") -> bool:
        """Write, or say what is lost; the simulation goes on. Whether it went well."""
        try:
            write()
        except (OSError, InputError) as error:
            why = (error.strerror or str(error)) if isinstance(error, OSError) else str(error)
            text = f"{what} cannot be written to {self.folder}: {why}"
            if what == "the recording":
                text += "; recording has stopped, what was written before can be replayed"
                self._beat.wanted = self._beat.wanted._replace(recording=0)
                self._close()
            self.error = (self.error[0] + 1, text)
            self._say(f"warning: {text}")
            return False
        return True


def _now() -> str:
    return f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}"
