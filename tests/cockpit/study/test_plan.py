"""What a study asks of whom: order of blocks and modes, and files that are none."""

from collections import Counter
from pathlib import Path

import pytest

from polydraulic import InputError
from polydraulic.cockpit.study.plan import check_study, read_study, study_tasks

TEXT = """
title = "Joint or coordinated"
machine = "wheel_loader"
pattern = "sae"
subjects = ["P01", "P02", "P03", "P04"]

[[blocks]]
name = "practice"
practice = true
exercises = ["tracking"]
modes = ["joint", "coordinated"]

[[blocks]]
name = "measured"
exercises = ["tracking", "trench"]
modes = ["joint", "coordinated"]
repetitions = 2
order = "counterbalanced"

[question]
text = "Which mode did you prefer?"
answers = ["joint", "coordinated", "neither"]
"""


@pytest.fixture
def written(tmp_path):
    def write(text=TEXT):
        path = tmp_path / "study.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_modes_go_around_from_subject_to_subject_where_they_are_counterbalanced(written):
    study = read_study(written())
    assert (study.pattern, study.answers) == ("sae", ("joint", "coordinated", "neither"))
    asked = {code: study_tasks(study, code) for code in study.subjects}
    for code, first in zip(study.subjects, ("joint", "coordinated") * 2, strict=True):
        tasks = asked[code]
        assert [task.number for task in tasks] == list(range(1, 11))
        assert [task.mode for task in tasks[:2]] == ["joint", "coordinated"]  # practice as it stands
        assert all(task.practice == (task.block == "practice") for task in tasks)
        second = {"joint": "coordinated", "coordinated": "joint"}[first]
        assert [(task.mode, task.repetition, task.exercise) for task in tasks[2:]] == [
            (mode, repetition, exercise)
            for mode in (first, second)
            for repetition in (1, 2)
            for exercise in ("tracking", "trench")
        ]
    assert Counter(tasks[2].mode for tasks in asked.values()) == {"joint": 2, "coordinated": 2}
    with pytest.raises(InputError, match="'P05': is not in the study"):
        study_tasks(study, "P05")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"P02"', '"Jane Doe"', "'Jane Doe': must be a code"),
        ('"P02"', '"P01"', "must differ"),
        ("repetitions = 2", "repetitions = 0", "blocks 2: repetitions = 0: must be a whole number from 1"),
        ('"counterbalanced"', '"random"', "order = 'random': must be one of"),
        ('modes = ["joint", "coordinated"]\nrep', 'modes = ["fast"]\nrep', "modes = 'fast': must be one of"),
        ("practice = true", "practise = true", "unknown key 'practise' in blocks 1"),
        ('name = "measured"', 'name = "practice"', "must differ"),
        ("title =", "titel =", "unknown key 'titel'"),
        ('answers = ["joint", "coordinated", "neither"]', "answers = []", "question.answers"),
        ('pattern = "sae"', "pattern = 3", "pattern = 3"),
    ],
)
def test_files_that_are_no_study_are_refused(written, old, new, said):
    assert old in TEXT
    with pytest.raises(InputError, match=said):
        read_study(written(TEXT.replace(old, new)))


def test_a_machine_must_have_what_is_asked_for(written, tmp_path):
    study, exercises = read_study(written()), {"tracking": 0, "trench": 0}
    check_study(study, "wheel_loader", exercises, "")
    for machine, has, why, said in (
        ("cat215b", exercises, "", "is of wheel_loader, and cat215b is driven"),
        ("wheel_loader", {"tracking": 0}, "", "has the exercise 'trench'"),
        ("wheel_loader", exercises, "no planar arm", "coordinated mode, which this machine has not: no planar arm"),
    ):
        with pytest.raises(InputError, match=said):
            check_study(study, machine, has, why)
    with pytest.raises(InputError, match="none.toml"):
        read_study(tmp_path / "none.toml")


def test_the_study_of_the_documentation_is_one(written):
    page = (Path(__file__).parents[3] / "docs" / "cockpit.md").read_text(encoding="utf-8")
    text = page.partition("```toml\n")[2].partition("```")[0]
    study = read_study(written(text))
    firsts = [study_tasks(study, code)[2].mode for code in study.subjects]
    assert firsts == ["joint", "coordinated", "joint", "coordinated"]
