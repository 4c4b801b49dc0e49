"""Drives that are recorded and replayed, exercises and what comes of them, as somebody at the page has them."""

import json

import pytest

from polydraulic.cockpit.recorded.drives import ENDING

# every frame from now on, by its simulated time
KEEP = """
window.kept = new Map();
const take = cockpit.connection.told.onFrame;
cockpit.connection.told.onFrame = (frame) => {
  window.kept.set(frame.time, [...cockpit.machine.columns.keys()].map((k) => frame.values[k]));
  take(frame);
};
"""
LOOKED_AT = 10  # frames of a drive that a replay is stopped at


@pytest.fixture
def recorded(page, recordings):
    """A drive of a few movements; name, its frames by time."""
    page.click("#lock")
    page.until_status("locked", True)
    before = set(page.status()["recordings"])
    page.press("Record")
    page.until("return cockpit.status.recording !== null")
    page.click("#lock")
    page.until_status("locked", False)
    page.js(KEEP)
    for key in ("KeyA", "ArrowDown", "KeyS"):
        page.key(key)
        page.run_for(0.7)
        page.key(key, down=False)
    page.run_for(0.3)
    page.press("Stop recording")
    page.until(
        "return cockpit.status.recording === null && cockpit.status.recordings.length > arguments[0]", len(before)
    )
    (name,) = set(page.status()["recordings"]) - before
    return name, page.js("const all = [...kept]; kept.clear(); return all")


def test_a_replay_has_the_bits_of_the_drive_and_is_gone_on_from(page, recorded):
    name, driven = recorded
    page.js("cockpit.connection.send({type: 'replay', name: arguments[0], action: 'play'})", name)
    page.until("return cockpit.status.replay?.playing && !document.getElementById('replay-bar').hidden")
    page.until("return cockpit.status.replay.time >= cockpit.status.replay.end - 0.1 && !cockpit.status.replay.playing")
    assert "cannot be replayed" not in page.js("return document.getElementById('notice').textContent")

    # which steps come as frames depends on the computer: the replay is sent to those that came when it was driven
    page.js("cockpit.connection.send({type: 'replay', name: arguments[0], action: 'pause'})", name)
    page.until("return cockpit.frame.number > arguments[0]", page.js("return cockpit.frame.number") + 2)
    ended, length = page.js("return [cockpit.frame.time, cockpit.status.replay.end]")  # by the clock of the drive
    driven = [(time, values) for time, values in driven if time <= ended]  # the recording ends before it is said so
    columns = page.js("return cockpit.machine.columns.map((column) => column.name)")
    # margins are of the step that was last looked at, which frames decide
    known = [k for k, column in enumerate(columns) if not column.startswith(("target.", "tipping."))]
    looked_at = [driven[k] for k in range(0, len(driven), max(1, len(driven) // LOOKED_AT))]
    for time, values in looked_at:
        page.js(
            "cockpit.connection.send({type: 'replay', name: arguments[0], action: 'seek', time: arguments[1]})",
            name,
            time - ended + length,
        )
        page.until("return cockpit.frame.time === arguments[0]", time)
        replayed = page.js("return [...cockpit.machine.columns.keys()].map((k) => cockpit.frame.values[k])")
        assert [replayed[k] for k in known] == [values[k] for k in known]
    assert len(looked_at) >= LOOKED_AT
    assert len({values[columns.index("swing.angle")] for _, values in looked_at}) > LOOKED_AT / 2  # and it did move

    middle = 0.5 * page.status()["replay"]["end"]
    page.js("cockpit.connection.send({type: 'replay', name: arguments[0], action: 'pause'})", name)
    page.js(
        "const bar = document.querySelector('#replay-bar input'); bar.value = arguments[0];"
        "bar.dispatchEvent(new Event('input')); bar.dispatchEvent(new Event('change'))",
        middle,
    )
    page.until("return Math.abs(cockpit.status.replay.time - arguments[0]) < 0.2", middle)
    page.click("#replay-bar [data-action=restart]")
    page.until("return cockpit.status.replay === null && cockpit.status.locked")
    page.click("#lock")
    page.until_status("locked", False)
    page.key("KeyD")
    page.until("return cockpit.readings.si('swing.voltage') < 0")


def test_a_drive_that_was_changed_is_refused(page, recorded, recordings):
    name, _ = recorded
    lines = (recordings / f"{name}{ENDING}").read_text().splitlines(keepends=True)
    stamps = [json.loads(line) for line in lines]
    place = next(k for k, stamp in enumerate(stamps) if any(stamp.get("levers", [])))
    stamps[place]["levers"] = [0.5 * volts for volts in stamps[place]["levers"]]
    (recordings / f"{name}{ENDING}").write_text("".join(json.dumps(stamp) + "\n" for stamp in stamps))
    page.js("cockpit.connection.send({type: 'replay', name: arguments[0], action: 'play'})", name)
    page.until("return document.getElementById('notice').textContent.includes('cannot be replayed')")


def test_an_exercise_shows_its_target_and_leaves_a_result(page):
    page.press("Exercises")
    page.js("document.querySelector('input[placeholder]').value = 'P07'")
    name = page.js("return cockpit.machine.exercises[0].name")
    page.js("document.querySelector('.exercise button').click()")
    page.until(
        "return cockpit.status.exercise !== null && cockpit.state.target !== null && cockpit.state.way.length > 1"
    )
    page.key("ArrowDown")
    page.until(
        "return [...document.querySelectorAll('.score dd')].some((value) => value.textContent.startsWith('0.') === false && value.textContent.endsWith('s'))"
    )
    page.key("ArrowDown", down=False)
    page.js("document.querySelector('.exercise.running button').click()")
    page.until_status("exercise", None)
    page.click("#results-open")
    page.until("return document.querySelectorAll('#results tbody tr').length > 0")
    shown = page.js("return document.getElementById('results').textContent")
    assert "P07" in shown
    assert name in shown
    assert "given up" in shown
    page.press("Close")
    page.press("Instruments")
    assert page.status()["locked"]  # nobody drives behind a page of results


def test_a_fault_is_switched_on_and_off(page):
    page.js("document.querySelector('.fault input').click()")
    page.until("return cockpit.status.faults.length === 1")
    page.js("document.querySelector('.fault input').click()")
    page.until_status("faults", [])
