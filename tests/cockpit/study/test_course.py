"""A study under way: what is asked for next, what is written, and how it goes on after a break."""

import csv

import pytest

from polydraulic import InputError
from polydraulic.cockpit.beat import Beat
from polydraulic.cockpit.exercises.results import read_results
from polydraulic.cockpit.keeper import Keeper
from polydraulic.cockpit.protocol import read_message
from polydraulic.cockpit.study.course import Course
from polydraulic.cockpit.study.plan import Block, Study
from polydraulic.cockpit.study.table import study_rows, table_path
from polydraulic.cockpit.web.seat import Seat

STUDY = Study(
    "Two modes",
    "wheel_loader",
    "sae",
    ("A1", "A2"),
    (
        Block("practice", ("pick and place",), ("joint",), 1, True, False),
        Block("measured", ("pick and place",), ("joint", "coordinated"), 1, False, True),
    ),
    "Which one?",
    ("joint", "coordinated"),
)


class Drivers:
    """A seat, and what a page says to it."""

    def __init__(self, cab, folder):
        self.beat = Beat(cab)
        self.keeper = Keeper(self.beat, folder, print, STUDY)
        self.seat = Seat(self.beat, self.keeper)
        self.page = self.seat.enter()
        self.say('{"type": "drive"}')

    def say(self, text):
        self.seat.hear(self.page, read_message(text))

    def study(self, action, text=None):
        self.say(f'{{"type": "study", "action": "{action}"' + ("" if text is None else f', "text": "{text}"') + "}")

    def attempt(self, done):
        """Begin what is asked for; it is finished at once, or stopped."""
        self.study("start")
        self.go()
        with pytest.raises(InputError, match="an exercise is running"):
            self.study("start")
        if done:
            trial = self.beat.cab._trial
            trial.over = trial.done = True
            self.beat.cab._show_trial()
            self.go()
        else:
            self.say('{"type": "exercise", "name": "", "action": "stop"}')
            self.go()
        with pytest.raises(InputError, match="is being written"):
            self.study("start")
        self.keeper.look()
        self.say('{"type": "exercise", "name": "", "action": "stop"}')
        self.go()

    def go(self):
        self.beat.cab.move(self.beat.wanted, 2)

    @property
    def shown(self):
        return self.seat.status(self.page)["study"]


@pytest.fixture
def drivers(cab, tmp_path):
    cab.uncoordinated = ""
    cab.coordination = object()  # that it can be: levers stay at rest
    found = Drivers(cab, tmp_path)
    cab._drive = lambda n, wanted: None
    return found


def test_a_subject_does_what_the_study_asks_for_and_answers(drivers, tmp_path):
    with pytest.raises(InputError, match="choose the code of the subject first"):
        drivers.study("start")
    drivers.study("subject", "A2")
    assert drivers.shown["task"]["block"] == "practice"
    for text, said in (
        ('{"type": "mode", "mode": "joint", "pattern": "iso"}', "the study prescribes the mode"),
        ('{"type": "guard", "on": true}', "the study prescribes the guard against tipping"),
        ('{"type": "exercise", "name": "trench", "action": "start"}', "the study prescribes exercises"),
        ('{"type": "fault", "name": "lift leaks", "on": true}', "the study prescribes faults"),
    ):
        with pytest.raises(InputError, match=said):
            drivers.say(text)
    drivers.attempt(done=False)
    assert drivers.shown["task"]["number"] == 1  # again
    drivers.attempt(done=True)
    assert (drivers.beat.wanted.mode, drivers.beat.wanted.pattern) == ("joint", "sae")
    assert drivers.shown["task"] == {
        "number": 2, "block": "measured", "practice": False, "exercise": "pick and place", "mode": "coordinated", "repetition": 1,
    }  # fmt: skip
    with pytest.raises(InputError, match="asked when all is done"):
        drivers.study("answer", "joint")
    drivers.attempt(done=True)
    assert drivers.beat.wanted.mode == "coordinated"
    drivers.study("skip")
    assert (drivers.shown["task"], drivers.shown["question"]) == (None, "Which one?")
    with pytest.raises(InputError, match="has done all"):
        drivers.study("start")
    with pytest.raises(InputError, match="must be one of"):
        drivers.study("answer", "both")
    drivers.study("answer", "joint")
    drivers.study("answer", "coordinated")  # thought again
    drivers.keeper.look()

    rows = list(csv.DictReader(table_path(STUDY, tmp_path).read_text(encoding="utf-8").splitlines()))
    assert [(row["task"], row["mode"], row["finished"], row["skipped"]) for row in rows] == [
        ("1", "joint", "False", "False"),
        ("1", "joint", "True", "False"),
        ("2", "coordinated", "True", "False"),
        ("3", "joint", "False", "True"),
    ]
    assert {row["exercise"] for row in rows} == {"pick and place"}
    assert {row["answer"] for row in rows} == {"coordinated"}
    assert {row["subject"] for row in rows} == {"A2"}
    assert float(rows[1]["time [s]"]) >= 0.0
    assert [row["practice"] for row in rows] == ["True", "True", "False", "False"]


def test_it_goes_on_after_a_break(drivers, cab, tmp_path):
    drivers.study("subject", "A1")
    drivers.attempt(done=True)
    drivers.study("skip")
    drivers.keeper.look()
    again = Keeper(drivers.beat, tmp_path, print, STUDY)
    again.course.choose("A1")
    assert (again.course.task.number, again.course.task.mode) == (3, "coordinated")
    again.course.choose("A2")
    assert again.course.task.number == 1
    other = Keeper(drivers.beat, tmp_path, print, STUDY._replace(title="Another"))
    other.course.choose("A1")
    assert other.course.task.number == 1
    assert study_rows(STUDY._replace(title="Another"), read_results(tmp_path)) == []


def test_without_a_study_there_is_none(cab, tmp_path):
    beat = Beat(cab)
    seat = Seat(beat, Keeper(beat, tmp_path, print))
    page = seat.enter()
    seat.hear(page, read_message('{"type": "drive"}'))
    assert seat.status(page)["study"] is None
    with pytest.raises(InputError, match="--study FILE"):
        seat.hear(page, read_message('{"type": "study", "action": "start"}'))


def test_results_of_a_study_that_was_changed_are_not_counted():
    said = {"title": STUDY.title, "task": 2, "block": "measured", "practice": False, "repetition": 1}
    done = {"subject": "A2", "exercise": "pick and place", "mode": "coordinated", "finished": True, "study": said}
    course = Course(STUDY, [done])
    course.choose("A2")
    assert course.task.number == 1
    changed = STUDY._replace(subjects=("A2", "A1"))  # who begins with which mode follows from the order
    with pytest.raises(InputError, match="task 2 of A2 was block measured, .*mode coordinated.*another title"):
        Course(changed, [done])
    with pytest.raises(InputError, match="task 9 of A2 was"):
        Course(STUDY, [done | {"study": said | {"task": 9}}])


def test_studies_of_other_titles_have_tables_of_their_own(tmp_path):
    titles = ["Modes A B", "Modes A/B", "Modes A_B", "m" * 61, "m" * 62]
    assert len({table_path(STUDY._replace(title=title), tmp_path) for title in titles}) == len(titles)
    assert table_path(STUDY._replace(title="Modes A B"), tmp_path).name == "study-modes_a_b.csv"
