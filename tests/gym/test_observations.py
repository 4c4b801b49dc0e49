"""The page lists the numbers of an observation as the environments do."""

from pathlib import Path

from polydraulic import load_machine
from polydraulic.gym.observations import limits_seen, numbers_seen
from polydraulic.gym.tasks.grade import grade_task
from polydraulic.gym.tasks.pick_place import pick_place_task
from polydraulic.gym.tasks.reach import reach_task
from polydraulic.gym.workspace import workspace_of

PAGE = Path(__file__).parents[2] / "docs" / "gym.md"
TASKS = (reach_task(), grade_task(), pick_place_task(100.0))


def rows():
    """Rows of the table: a number, and which tasks show it."""
    work = workspace_of(load_machine("wheel_loader"), lambda states, span: states)
    numbers, shown = {}, {}
    for task in TASKS:
        for number in numbers_seen(work, task):
            numbers[number.name] = number
            shown.setdefault(number.name, []).append(task.name)
    for name, number in numbers.items():
        of = "all" if len(shown[name]) == len(TASKS) else ", ".join(shown[name])
        yield f"| `{name}` | {number.unit} | {number.means} | {of} |"


def test_the_page_lists_what_is_seen():
    text = PAGE.read_text().partition("<!-- observations -->\n")[2].partition("<!-- end of observations -->")[0]
    assert text.splitlines()[2:] == list(rows())


def test_joints_that_turn_all_round_are_not_placed_and_those_that_slide_have_a_speed():
    work = workspace_of(load_machine("loader_crane"), lambda states, span: states)
    numbers = numbers_seen(work, TASKS[0])
    names = [number.name for number in numbers]
    assert names[:4] == ["slew.rate", "slew.spool", "slew.load", "inner.travel"]
    assert {"reach.travel", "reach.speed"} < set(names)
    assert len(numbers) == len(limits_seen(numbers)) == 5 * 4 - 1 + 3
