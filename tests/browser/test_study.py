"""A study with people, as one of its subjects has it: what is asked, an attempt that is stopped, one that is finished, the question, the table."""

import csv
import time

import pytest

from helpers.driven_page import DrivenPage, served_cockpit

STUDY = """
title = "Joint or coordinated"
machine = "wheel_loader"
pattern = "sae"
subjects = ["P01", "P02"]

[[blocks]]
name = "practice"
practice = true
exercises = ["trench"]
modes = ["joint"]

[[blocks]]
name = "measured"
exercises = ["tracking"]
modes = ["joint", "coordinated"]
order = "counterbalanced"

[question]
text = "Which mode did you prefer?"
answers = ["joint", "coordinated"]
"""


@pytest.fixture
def study_page(browser, tmp_path):
    """The page of a study, and the folder of its results."""
    (tmp_path / "modes.toml").write_text(STUDY)
    with served_cockpit("wheel_loader", tmp_path / "results", "--study", str(tmp_path / "modes.toml")) as url:
        first = browser.current_window_handle
        browser.switch_to.new_window("window")
        try:
            page = DrivenPage(browser, url)
            page.open("#flat")
            page.until_status("driver", "you")
            yield page, tmp_path / "results"
        finally:
            browser.close()
            browser.switch_to.window(first)


def asked(page):
    """What the card says that is to be done next."""
    return page.js("return [...document.querySelectorAll('#study p')].map((line) => line.textContent).join(' | ')")


def attempts(folder, n):
    """Rows of the table, once there are so many."""
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        tables = list(folder.glob("study-*.csv"))
        rows = list(csv.DictReader(tables[0].read_text().splitlines())) if tables else []
        if len(rows) >= n:
            return rows
        time.sleep(0.05)
    raise AssertionError(f"{len(rows)} attempts are written, and not {n}")


def skip(page, number):
    page.press("Leave out")
    page.until("return (cockpit.status.study.task?.number ?? 0) !== arguments[0]", number)


def test_a_subject_is_led_through_a_study(study_page):
    page, folder = study_page
    assert page.js("return [...document.querySelectorAll('#tabs button')].some((tab) => tab.textContent === 'Study')")
    page.js("document.querySelector('#study select').value = 'P02'")
    page.press("Go on")
    page.until("return cockpit.status.study.subject === 'P02' && cockpit.status.study.task.number === 1")
    page.until("return document.querySelector('#study').textContent.includes('Practice: practice, attempt 1')")
    assert "1 of 3: trench, joint mode" in asked(page)

    page.press("Start")
    page.until("return cockpit.status.exercise?.name === 'trench' && cockpit.status.pattern === 'sae'")
    # what a study prescribes is not the subject's to change
    page.click("[data-mode=coordinated]")
    page.until("return document.getElementById('notice').textContent.includes('the study prescribes the mode')")
    page.click("#lock")
    page.until_status("locked", False)
    page.key("KeyS")
    page.run_for(1.0)
    page.key("KeyS", down=False)
    page.press("Stop")
    page.until_status("exercise", None)
    page.until("return document.querySelector('#study').textContent.includes('it is asked for again')")
    assert page.status()["study"]["task"]["number"] == 1
    page.until(
        "return ![...document.querySelectorAll('#study button')].find((b) => b.textContent === 'Leave out').disabled"
    )
    attempts(folder, 1)  # one that is being written is not left out
    skip(page, 1)

    # the second subject begins with the second mode
    assert "2 of 3: tracking, coordinated mode" in asked(page)
    skip(page, 2)
    assert "3 of 3: tracking, joint mode" in asked(page)
    page.press("Start")
    page.until("return cockpit.status.exercise?.name === 'tracking' && cockpit.state.target !== null")
    page.until("return cockpit.frame.time > 10")
    page.key("KeyS")
    page.run_for(0.5)
    page.key("KeyS", down=False)
    page.until("return cockpit.frame.time > 45")  # the target moves for a minute, whoever drives
    page.until("return cockpit.status.study.question !== ''")
    page.until("return document.querySelector('#study').textContent.includes('Which mode did you prefer?')")
    page.press("coordinated")
    page.until("return cockpit.status.study.answer === 'coordinated'")

    page.until("return document.querySelector('#study').textContent.includes('Thank you')")
    end = time.monotonic() + 60.0
    while (rows := attempts(folder, 4))[0]["answer"] == "" and time.monotonic() < end:
        time.sleep(0.05)
    told = [
        [row[key] for key in ("subject", "task", "exercise", "mode", "finished", "skipped", "answer")] for row in rows
    ]
    assert told == [
        ["P02", "1", "trench", "joint", "False", "False", "coordinated"],
        ["P02", "1", "trench", "joint", "False", "True", "coordinated"],
        ["P02", "2", "tracking", "coordinated", "False", "True", "coordinated"],
        ["P02", "3", "tracking", "joint", "True", "False", "coordinated"],
    ]
    assert float(rows[3]["effort [s]"]) > 0.0
    assert float(rows[3]["time [s]"]) == pytest.approx(60.0, abs=0.1)
    assert page.said() == []
