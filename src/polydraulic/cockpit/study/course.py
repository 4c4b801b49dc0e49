"""How far a subject has come in a study: what is asked for next, what is done, what was answered; found again in the results after a break."""

from collections.abc import Mapping, Sequence
from typing import Any

from polydraulic.cockpit.study.plan import Study, StudyTask, study_tasks
from polydraulic.errors import InputError, briefly

ANSWER = "answer"  # of a result that is no attempt


class Course:
    """A study under way, of one subject after the other.

    Parameters
    ----------
    study : Study
    results : sequence of mappings
        All that stands in the file of results.

    Attributes
    ----------
    study : Study
    subject : str
        Empty before one is chosen.

    Raises
    ------
    InputError
        Results of a study of this title that asked for something else.
    """

    def __init__(self, study: Study, results: Sequence[Mapping[str, Any]]) -> None:
        self.study, self.subject = study, ""
        self._tasks: tuple[StudyTask, ...] = ()
        self._done: dict[str, set[int]] = {code: set() for code in study.subjects}
        self._answers: dict[str, str] = {}
        self._running: tuple[int, StudyTask] | None = None  # number of the wish
        for result in results:
            self._take(result)

    def _take(self, result: Mapping[str, Any]) -> None:
        of = result.get("study")
        subject = result.get("subject")
        if not isinstance(of, Mapping) or of.get("title") != self.study.title or subject not in self._done:
            return
        if ANSWER in of:
            self._answers[str(subject)] = str(of[ANSWER])
        elif result.get("finished") or of.get("skipped"):
            asked = {key: result.get(key, of.get(key)) for key in ("block", "exercise", "mode", "repetition")}
            tasks = study_tasks(self.study, str(subject))
            task = next((task for task in tasks if task.number == of.get("task")), None)
            if task is None or any(value != getattr(task, key) for key, value in asked.items()):
                raise InputError(
                    f"the results in the folder are of another study {self.study.title!r}: task {briefly(of.get('task'))} of {subject} was "
                    f"{', '.join(f'{key} {value}' for key, value in asked.items())}; a study that was changed needs another title, or another folder"
                )
            self._done[str(subject)].add(task.number)

    @property
    def task(self) -> StudyTask | None:
        """What is asked for next, or is being tried."""
        done = self._done.get(self.subject, set())
        return next((task for task in self._tasks if task.number not in done), None)

    @property
    def wish(self) -> int:
        """Number of the wish whose result is not written yet; 0 for none."""
        return 0 if self._running is None else self._running[0]

    def choose(self, subject: str) -> None:
        """Go on with a subject, from where this one was.

        Raises
        ------
        InputError
            A code that is not one of the study.
        """
        self._tasks = study_tasks(self.study, subject)
        self.subject, self._running = subject, None

    def wanted(self) -> StudyTask:
        """What is to begin now.

        Raises
        ------
        InputError
            Nobody is chosen, or all is done.
        """
        if not self.subject:
            raise InputError("choose the code of the subject first")
        task = self.task
        if task is None:
            raise InputError(f"{self.subject} has done all that the study asks for")
        return task

    def begin(self, wish: int) -> None:
        """Let the wish of that number be an attempt at what is asked for."""
        self._running = wish, self.wanted()

    def ended(self, wish: int, finished: bool) -> dict[str, Any] | None:
        """What a result says of the study, None if its attempt belongs to none; one that was not finished is asked for again."""
        if self._running is None or self._running[0] != wish:
            return None
        task, self._running = self._running[1], None
        if finished:
            self._done[self.subject].add(task.number)
        return self._said(task)

    def skip(self) -> dict[str, Any]:
        """Leave out what is asked for; what a result says of it.

        Raises
        ------
        InputError
            Nothing is asked for.
        """
        task = self.wanted()
        self._done[self.subject].add(task.number)
        self._running = None
        return self._said(task) | {"skipped": True, "exercise": task.exercise, "mode": task.mode}

    def answer(self, text: str) -> dict[str, Any]:
        """Take an answer to the question; what a result says of it.

        Raises
        ------
        InputError
            There is no question yet, or not this answer.
        """
        if not self.study.question or not self.subject or self.task is not None:
            raise InputError("the question is asked when all is done")
        if text not in self.study.answers:
            raise InputError(f"answer = {briefly(text)}: must be one of {list(self.study.answers)}")
        self._answers[self.subject] = text
        return {"title": self.study.title, ANSWER: text}

    def shown(self) -> dict[str, Any]:
        """What a page is told."""
        task, study = self.task, self.study
        return {
            "title": study.title,
            "subjects": list(study.subjects),
            "subject": self.subject,
            "task": None if task is None else task._asdict(),
            "tasks": len(self._tasks),
            "question": study.question if self.subject and task is None else "",
            "answers": list(study.answers),
            "answer": self._answers.get(self.subject, ""),
        }

    def _said(self, task: StudyTask) -> dict[str, Any]:
        return {
            "title": self.study.title,
            "task": task.number,
            "block": task.block,
            "practice": task.practice,
            "repetition": task.repetition,
        }
