"""What a study asks of each person, from its file: blocks of exercises in prescribed modes, and a question at the end.

::

    title = "Joint or coordinated"
    machine = "wheel_loader"          # checked against the one that is driven, if given
    pattern = "iso"
    subjects = ["P01", "P02", "P03", "P04"]

    [[blocks]]
    name = "practice"
    practice = true                   # marked in the table
    exercises = ["tracking"]
    modes = ["joint", "coordinated"]
    repetitions = 1

    [[blocks]]
    name = "measured"
    exercises = ["tracking", "trench"]
    modes = ["joint", "coordinated"]
    repetitions = 3
    order = "counterbalanced"         # or "given"

    [question]
    text = "Which mode did you prefer?"
    answers = ["joint", "coordinated", "neither"]

All of a block is done in its first mode, then in the next: exercise after exercise, as often as there are repetitions. Where the order is
counterbalanced, subject number k begins with mode k, and goes on from there in the order of the file, around it: as many
people begin with each mode, if their number is a multiple of that of the modes.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.keys import check_keys

MODES = ("joint", "coordinated")
PATTERNS = ("iso", "sae")
ORDERS = ("given", "counterbalanced")
MOST_SUBJECTS, MOST_REPETITIONS, MOST_BLOCKS, MOST_ANSWERS = 1000, 100, 50, 9
_LONGEST = 200  # letters of a text, 32 of a code
_CODE = 32


class Block(NamedTuple):
    """A part of a study, done as a whole.

    Attributes
    ----------
    name : str
    exercises, modes : tuple of str
    repetitions : int
    practice : bool
    counterbalanced : bool
        Whether the order of modes goes around from subject to subject.
    """

    name: str
    exercises: tuple[str, ...]
    modes: tuple[str, ...]
    repetitions: int
    practice: bool
    counterbalanced: bool


class StudyTask(NamedTuple):
    """One attempt that is asked for; `number` counts from 1 through the whole study, `repetition` through the same attempts of a block."""

    number: int
    block: str
    practice: bool
    exercise: str
    mode: str
    repetition: int


class Study(NamedTuple):
    """A study.

    Attributes
    ----------
    title : str
    machine : str
        Empty for any.
    pattern : str
    subjects : tuple of str
        Codes; nothing personal.
    blocks : tuple of Block
    question : str
        Empty for none.
    answers : tuple of str
    """

    title: str
    machine: str
    pattern: str
    subjects: tuple[str, ...]
    blocks: tuple[Block, ...]
    question: str
    answers: tuple[str, ...]


def study_tasks(study: Study, subject: str) -> tuple[StudyTask, ...]:
    """All that a subject is asked to do, in order.

    Raises
    ------
    InputError
        A code that is not one of the study.
    """
    if subject not in study.subjects:
        raise InputError(f"subject = {briefly(subject)}: is not in the study; it has {list(study.subjects)}")
    place, found = study.subjects.index(subject), []
    for block in study.blocks:
        first = place % len(block.modes) if block.counterbalanced else 0
        for mode in block.modes[first:] + block.modes[:first]:
            for repetition in range(1, block.repetitions + 1):
                for exercise in block.exercises:
                    found.append((block.name, block.practice, exercise, mode, repetition))
    return tuple(StudyTask(number, *one) for number, one in enumerate(found, 1))


def read_study(path: str | Path) -> Study:
    """Read a study file.

    Raises
    ------
    InputError
        A file that cannot be read, or what in it cannot be: which key, and what is allowed.
    """
    path = Path(path)
    data = read_toml(path)
    keys = ("title", "machine", "pattern", "subjects", "blocks", "question")
    check_keys(data, keys, ("title", "subjects", "blocks"), file=str(path))
    subjects = _texts(data["subjects"], f"{path}: subjects", MOST_SUBJECTS)
    for code in subjects:
        if len(code) > _CODE or not all(c.isalnum() or c in "-_" for c in code):
            raise InputError(
                f"{path}: subjects: {briefly(code)}: must be a code of at most {_CODE} letters, digits, - and _; nothing personal"
            )
    if not isinstance(data["blocks"], list) or not 1 <= len(data["blocks"]) <= MOST_BLOCKS:
        raise InputError(f"{path}: blocks = {briefly(data['blocks'])}: must be 1 to {MOST_BLOCKS} tables [[blocks]]")
    blocks = tuple(_block(block, f"blocks {k}", str(path)) for k, block in enumerate(data["blocks"], 1))
    names = [block.name for block in blocks]
    if len(set(names)) < len(names):
        raise InputError(f"{path}: blocks are named {names}: must differ")
    question: str = ""
    answers: tuple[str, ...] = ()
    if "question" in data:
        check_keys(data["question"], ("text", "answers"), ("text", "answers"), "question", str(path))
        question = _text(data["question"]["text"], f"{path}: question.text")
        answers = _texts(data["question"]["answers"], f"{path}: question.answers", MOST_ANSWERS)
    return Study(
        _text(data["title"], f"{path}: title"),
        _text(data["machine"], f"{path}: machine") if "machine" in data else "",
        _one_of(data.get("pattern", "iso"), PATTERNS, f"{path}: pattern"),
        subjects,
        blocks,
        question,
        answers,
    )


def check_study(study: Study, machine: str, exercises: Mapping[str, Any], uncoordinated: str) -> None:
    """Check that a machine can be asked for all of a study.

    Parameters
    ----------
    study : Study
    machine : str
        Name of the machine that is driven.
    exercises : mapping by name
        That it has.
    uncoordinated : str
        Why it cannot be coordinated; empty if it can.

    Raises
    ------
    InputError
    """
    if study.machine and study.machine != machine:
        raise InputError(
            f"the study {study.title!r} is of {study.machine}, and {machine} is driven: give --machine {study.machine}"
        )
    for block in study.blocks:
        for name in block.exercises:
            if name not in exercises:
                raise InputError(
                    f"the study's block {block.name!r} has the exercise {name!r}; this machine has {list(exercises)}"
                )
        if "coordinated" in block.modes and uncoordinated:
            raise InputError(
                f"the study's block {block.name!r} has coordinated mode, which this machine has not: {uncoordinated}"
            )


def _block(data: Any, where: str, file: str) -> Block:
    needed = ("name", "exercises", "modes")
    check_keys(data, (*needed, "repetitions", "practice", "order"), needed, where, file)
    at = f"{file}: {where}"
    repetitions, practice = data.get("repetitions", 1), data.get("practice", False)
    if repetitions.__class__ is not int or not 1 <= repetitions <= MOST_REPETITIONS:
        raise InputError(
            f"{at}: repetitions = {briefly(repetitions)}: must be a whole number from 1 to {MOST_REPETITIONS}"
        )
    if not isinstance(practice, bool):
        raise InputError(f"{at}: practice = {briefly(practice)}: must be true or false")
    modes = _texts(data["modes"], f"{at}: modes", len(MODES))
    for mode in modes:
        _one_of(mode, MODES, f"{at}: modes")
    exercises = _texts(data["exercises"], f"{at}: exercises", MOST_BLOCKS)
    order = _one_of(data.get("order", "given"), ORDERS, f"{at}: order")
    return Block(_text(data["name"], f"{at}: name"), exercises, modes, repetitions, practice, order == ORDERS[1])


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str) or not value.strip() or len(value) > _LONGEST or not value.isprintable():
        raise InputError(f"{where} = {briefly(value)}: must be a text of 1 to {_LONGEST} letters in one line")
    return value


def _texts(value: Any, where: str, most: int) -> tuple[str, ...]:
    if not isinstance(value, list) or not 1 <= len(value) <= most:
        raise InputError(f"{where} = {briefly(value)}: must be a list of 1 to {most} texts")
    found = tuple(_text(one, where) for one in value)
    if len(set(found)) < len(found):
        raise InputError(f"{where} = {briefly(value)}: must differ from each other")
    return found


def _one_of(value: Any, words: tuple[str, ...], where: str) -> str:
    if value not in words:
        raise InputError(f"{where} = {briefly(value)}: must be one of {list(words)}")
    return str(value)
