"""Hands on levers: what is pressed, pulled or pushed moves the right joint the right way, and nothing when hands are off."""

import pytest

from helpers.driven_page import DrivenPage

MOVED = 0.05  # rad, by which a joint that is meant moves at least

# pattern, key, function, direction: ISO 10968 and SAE J1177; positive is to the left, up and out
KEYS = [
    ("iso", "KeyA", "swing", 1),
    ("iso", "KeyD", "swing", -1),
    ("iso", "KeyW", "stick", 1),
    ("iso", "KeyS", "stick", -1),
    ("iso", "ArrowUp", "boom", -1),
    ("iso", "ArrowDown", "boom", 1),
    ("sae", "KeyA", "swing", 1),
    ("sae", "KeyW", "boom", -1),
    ("sae", "KeyS", "boom", 1),
    ("sae", "ArrowUp", "stick", 1),
    ("sae", "ArrowDown", "stick", -1),
]


def moves(page, function, direction):
    """Wait until a joint has moved this way; no other lever is anything but centred."""
    before = page.positions()[function]
    page.until(
        "const f = cockpit.machine.functions.find((one) => one.name === arguments[0]);"
        "return arguments[1] * (cockpit.readings.si(f.position) - arguments[2]) > arguments[3]",
        function,
        direction,
        before,
        MOVED,
    )
    volts = page.voltages()
    assert direction * volts.pop(function) > 0.0
    assert set(volts.values()) == {0.0}


@pytest.mark.parametrize(("pattern", "key", "function", "direction"), KEYS)
def test_a_key_moves_its_joint_its_way(page, pattern, key, function, direction):
    page.begin(pattern)
    page.key(key)
    moves(page, function, direction)
    page.key(key, down=False)
    page.until("return cockpit.levers.axes.every((value) => value === 0)")
    page.until_applied()
    assert set(page.voltages().values()) == {0.0}


def test_a_pad_moves_joints_beyond_its_dead_zone(page):
    page.js("padIn = true; pad.axes = [0.1, 0.1, -0.1, 0.05]")
    page.run_for(0.3)
    assert page.js("return [cockpit.levers.axes, cockpit.levers.source]") == [[0] * 6, "none"]
    page.js("pad.axes = [-1, 0, 0, 0]")  # the left stick to the left
    moves(page, "swing", 1)
    assert page.js("return cockpit.levers.source") == "pad"
    page.js("pad.axes = [0, 0, 0, 1]")  # the right stick pulled back: axes of pads count down as positive
    moves(page, "boom", 1)


def test_a_pad_that_is_held_while_levers_are_let_go_must_be_centred_first(page):
    page.js("padIn = true; pad.axes = [-1, 0, 0, 0]")
    page.until("return cockpit.levers.axes[0] === -1")
    page.js("dispatchEvent(new Event('blur'))")
    page.run_for(0.3)
    assert page.js("return cockpit.levers.axes[0]") == 0
    page.js("pad.axes = [0, 0, 0, 0]")
    page.run_for(0.1)
    page.js("pad.axes = [-1, 0, 0, 0]")
    page.until("return cockpit.levers.axes[0] === -1")


def test_a_finger_moves_a_stick_on_the_screen(page):
    stick = "[data-stick=right] .stick"
    page.touch(stick, "pointerdown", (0.0, 0.0))
    page.touch(stick, "pointermove", (0.0, -1.0))
    moves(page, "boom", 1)
    page.touch(stick, "pointerup")
    page.until("return cockpit.levers.axes.every((value) => value === 0)")


def test_a_key_that_repeats_or_belongs_to_a_field_moves_nothing(page):
    page.key("KeyA", repeat=True)
    page.js(
        "const field = document.querySelector('input[placeholder]');"
        "field.dispatchEvent(new KeyboardEvent('keydown', {code: 'KeyA', bubbles: true}))"
    )
    page.run_for(0.2)
    assert page.js("return cockpit.levers.axes") == [0] * 6


def test_the_machine_is_locked_at_its_start_and_stands_still(page):
    page.begin(locked=True)
    before = page.positions()
    page.key("KeyA")
    page.key("ArrowDown")
    page.until("return cockpit.levers.axes[0] === -1 && cockpit.frame.seq === cockpit.connection.seq")
    page.run_for(0.5)
    assert set(page.voltages().values()) == {0.0}
    assert page.positions() == pytest.approx(before, abs=1e-3)
    assert page.js("return [cockpit.frame.flags & 1, document.body.dataset.locked]") == [1, "true"]


@pytest.mark.parametrize(
    "away",
    [
        "dispatchEvent(new Event('blur'))",
        "Object.defineProperty(document, 'hidden', {value: true, configurable: true}); document.dispatchEvent(new Event('visibilitychange')); delete document.hidden",
        "dispatchEvent(new Event('gamepaddisconnected'))",
    ],
    ids=["blur", "hidden", "pad gone"],
)
def test_levers_are_neutral_when_the_hand_is_away(page, away):
    page.key("KeyA")
    page.until("return cockpit.readings.si('swing.voltage') !== 0")
    page.js(away)
    page.until("return cockpit.frame.seq === cockpit.connection.seq && cockpit.readings.si('swing.voltage') === 0")
    assert page.js("return cockpit.levers.axes") == [0] * 6


def test_in_coordinated_mode_a_stick_moves_the_tip_outward_on_its_level(page):
    page.click("[data-mode=coordinated]")
    page.until_status("mode", "coordinated")
    assert "reach out" in page.js("return document.querySelector('[data-stick=left] .north').textContent")
    x, z = page.value("effector.x"), page.value("effector.z")
    page.key("KeyW")
    page.until("return cockpit.readings.si('effector.x') > arguments[0] + 0.3", x)
    assert abs(page.value("effector.z") - z) < 0.1
    volts = page.voltages()
    assert volts["boom"] != 0.0
    assert volts["stick"] != 0.0


def test_the_guard_slows_what_would_tip_the_machine_and_refuses_it(page):
    page.js("cockpit.connection.send({type: 'payload', mass: 3000})")
    page.click("[data-mode=coordinated]")
    page.until_status("mode", "coordinated")
    page.click("#guard")
    page.until_status("guard", True)
    page.until("return document.getElementById('guard').classList.contains('on')")
    page.run_for(2.0)
    page.key("KeyW")
    page.until(
        "return (cockpit.frame.flags & 512) !== 0 && document.querySelector('#tipping .guard').textContent !== ''"
    )
    assert page.js("return document.querySelector('#lamps').textContent").count("tip guard") == 1
    page.until("return cockpit.readings.si('tipping.guard') === 0")
    page.until("return document.querySelector('#tipping .guard').textContent.startsWith('Guard: refused')")
    assert page.value("tipping.distance") > 0.15
    page.key("KeyW", down=False)
    page.key("KeyS")
    page.until("return cockpit.readings.si('tipping.distance') > 0.3")
    page.key("KeyS", down=False)
    page.until("return cockpit.readings.si('tipping.guard') === 1")
    page.until("return document.querySelector('#tipping .guard').textContent === ''")
    page.click("#guard")
    page.until_status("guard", False)


def test_the_space_bar_locks(page):
    page.key("KeyA")
    page.until("return cockpit.readings.si('swing.voltage') !== 0")
    page.key("Space")
    page.until_status("locked", True)
    page.until("return cockpit.readings.si('swing.voltage') === 0")


def test_each_lever_says_what_it_does(page):
    def words(side):
        return [
            page.js("return document.querySelector(arguments[0]).textContent", f"[data-stick={side}] .{end}")
            for end in ("north", "south")
        ]

    assert [("stick" in text, "boom" in text) for text in words("left")] == [(True, False)] * 2
    page.begin("sae")
    page.until("return document.querySelector('[data-stick=left] .north').textContent.includes('boom')")
    assert [("stick" in text, "boom" in text) for text in words("right")] == [(True, False)] * 2


def test_one_page_drives_and_the_other_watches(page):
    browser, first = page.browser, page.browser.current_window_handle
    browser.switch_to.new_window("window")
    try:
        other = DrivenPage(browser, page.url)
        other.open("#flat")
        other.until_status("driver", "other")
        assert other.js("return document.getElementById('driver').textContent").startswith("Watching")
        other.click("#drive")
        other.until("return document.getElementById('notice').textContent.includes('another page drives')")
        other.key("KeyA")
        other.run_for(0.3)
        assert other.js("return [cockpit.connection.seq, cockpit.readings.si('swing.voltage')]") == [0, 0]
        assert other.status()["driver"] == "other"
    finally:
        browser.close()
        browser.switch_to.window(first)
    assert page.status()["driver"] == "you"
