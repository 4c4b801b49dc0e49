"""What is seen: all views, in space and in the plane, instruments, and nothing that the page's rules forbid."""

import io
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

VIEWS = ("cab", "side", "top")


@pytest.fixture
def in_space(page):
    page.size(900, 506)  # pictures cost what their size is
    page.click("#kind")
    assert page.js("return cockpit.stage.kind") == "space"
    yield page
    page.size(1280, 720)
    page.js("if (cockpit.stage.kind === 'space') document.getElementById('kind').click()")


def picture(page):
    """The machine's part of the page, as numbers from 0 to 255."""
    png = page.browser.find_element("id", "stage").screenshot_as_png
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=float)


def drawn(page, view):
    before = page.js("return cockpit.pictures")
    page.click(f"[data-view={view}]")
    page.until("return cockpit.pictures >= arguments[0]", before + 3)
    return picture(page)


def test_every_view_in_space_shows_the_machine(in_space, tmp_path):
    machine_is_shown(in_space, VIEWS, tmp_path)


def test_every_view_in_the_plane_shows_the_machine(page, tmp_path):
    machine_is_shown(page, VIEWS[1:], tmp_path)  # there is no cab


def machine_is_shown(page, views, tmp_path):
    shown = {view: drawn(page, view) for view in views}
    for view, pixels in shown.items():
        Image.fromarray(pixels.astype(np.uint8)).save(tmp_path / f"{view}.png")
        red, _, blue = np.moveaxis(pixels, -1, 0)
        amber = float(np.mean((red - blue > 90) & (red > 120)))
        assert 0.01 < amber < 0.6, f"{view}: share of the machine's colour {amber:.3f}"
    for a, b in pairwise(views):
        assert np.abs(shown[a] - shown[b]).mean() > 5.0
    page.click("[data-view=side]")
    before = drawn(page, "side")
    page.key("ArrowDown")
    page.run_for(1.0)
    page.key("ArrowDown", down=False)
    assert np.abs(drawn(page, "side") - before).mean() > 0.5  # the boom has gone up


def test_the_cab_is_on_the_left_and_left_is_up_seen_from_above(in_space):
    """The tip at the end of a swing to the left is above the middle of the view from above, and at y > 0."""
    page = in_space
    page.key("KeyA")
    page.until("return cockpit.readings.si('swing.angle') > 0.4")
    page.key("KeyA", down=False)
    assert page.value("effector.y") > 1.0
    from_above = page.js(
        "const {eye} = cockpit.stage.view; cockpit.stage.setView('top'); cockpit.stage.draw(cockpit.state);"
        "const {camera} = eye; camera.updateMatrixWorld();"
        "const seen = (p) => camera.position.clone().set(...p).project(camera);"
        "const cab = cockpit.machine.drawing.bodies.find((body) => body.fill === '#f4f6f8' && body.across.length);"
        "const tip = seen(cockpit.state.tip), foot = seen([0, 0, 0]);"
        "return [tip.y - foot.y, tip.x - foot.x, Math.min(...cab.across.flat())]"
    )
    page.js("cockpit.stage.setView('side')")
    assert from_above[0] > 0.05  # up on the screen
    assert from_above[1] > 0.05  # and ahead, to the right
    assert from_above[2] > 0.0  # the cab is where y is positive


def test_a_lost_context_leaves_the_flat_view(in_space):
    page = in_space
    page.js("cockpit.stage.canvas.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()")
    page.until("return cockpit.stage.kind === 'flat'")
    assert "flat" in page.js("return document.getElementById('notice').textContent")
    assert np.std(drawn(page, "side")) > 10.0
    assert [line for line in page.said() if "Context Lost" not in line] == []


def test_instruments_say_what_the_frame_says(page):
    page.key("KeyA")
    page.run_for(1.5)
    row = page.js(
        "cockpit.instruments.update(cockpit.readings);"
        "const card = document.querySelectorAll('.pump')[1], r = cockpit.readings;"
        "return [card.querySelector('h2').textContent, [...card.querySelectorAll('.legend b')].map((b) => b.textContent),"
        " ['swing.q_in', 'stick.q_in', 'series.q_bypass', 'series.q_relief'].map((c) => Math.round(r.shown(c)) + 0)]"
    )
    assert "swing → stick" in row[0]
    assert "bar" in row[0]
    assert "l/min" in row[0]
    assert [int(text) for text in row[1]] == row[2]
    assert row[2][0] > 50  # the swing comes first and takes the flow


def test_tipping_is_shown_as_a_bar_and_on_the_ground(page):
    """The weight of a heavy load outward of the tracks: the alarm, and the edge over which it would tip."""
    page.js("cockpit.send({type: 'payload', mass: 6000})")
    page.until("return (cockpit.readings.flags & 256) !== 0")
    page.until("return document.querySelector('#tipping h2 b').textContent === 'forward'")  # by its weight alone, too
    page.until("return document.getElementById('tipping').classList.contains('alarm')")
    page.until("return [...document.querySelectorAll('#events li')].some((one) => one.textContent.includes('tip'))")
    edge, least, corners, weight, lamp = page.js(
        "const r = cockpit.readings, s = cockpit.state.standing;"
        "return [document.querySelector('#tipping h2 b').textContent, r.si('tipping.distance'), s.corners, s.weight,"
        " document.querySelector('#lamps .lit').textContent]"
    )
    assert (edge, lamp) == ("forward", "tipping")
    ahead = max(x for x, _, _ in corners)
    assert ahead - weight[0] == pytest.approx(least, abs=0.05)  # it swings a little
    assert page.js("return cockpit.machine.chassis.edges[cockpit.readings.si('tipping.edge')]") == edge
    page.js("cockpit.send({type: 'reset'})")
    page.until("return (cockpit.readings.flags & 256) === 0")


def test_nothing_comes_from_elsewhere_and_no_rule_is_broken(page):
    addresses = page.js("return performance.getEntriesByType('resource').map((entry) => new URL(entry.name).host)")
    assert set(addresses) == {page.js("return location.host")}
    assert page.js("return document.querySelectorAll('[style*=expression], script:not([src]), style').length") == 0
    assert page.said() == []


def test_parts_of_the_page_do_their_sums(page):
    found = page.browser.execute_async_script(
        "const done = arguments[arguments.length - 1];"
        "Promise.all(['gamepad', 'connection', 'readings', 'kinematics'].map((name) => import(`/page/${name}.js`))).then(([g, c, r, k]) => done(["
        "  [g.rescaled(0.1), g.rescaled(-0.1), g.rescaled(1), g.rescaled(-1), g.rescaled(1.2)],"
        "  c.readFrame(new ArrayBuffer(30), 2), c.readFrame(new ArrayBuffer(32), 2).number,"
        "  [r.number(-0.4), r.number(-12.34, 1), r.number(NaN), r.readable(0.0123, 'm'), r.readable(3, '1')],"
        "  k.hull([[0, 0], [1, 0], [0.5, 0.1]], [0, 0, 0]).length]))"
    )
    assert found[0] == pytest.approx([0.0, 0.0, 1.0, -1.0, 1.0])
    assert found[1:3] == [None, 0]
    assert found[3] == ["0", "−12.3", "–", "12.3 mm", "3"]
    assert found[4] >= 3


@pytest.mark.parametrize("width", [1280, 900, 600, 390])
def test_both_sticks_and_the_lock_are_within_a_narrow_window(page, width):
    page.size(width, 800)
    places = page.js(
        "return ['[data-stick=left]', '[data-stick=right]', '#lock'].map((one) => document.querySelector(one).getBoundingClientRect().toJSON())"
    )
    page.size(1280, 720)
    assert all(0.0 <= place["left"] < place["right"] <= width for place in places)
    for one, other in pairwise([*places, places[0]]):
        apart = one["right"] <= other["left"] or other["right"] <= one["left"]
        assert apart or one["bottom"] <= other["top"] or other["bottom"] <= one["top"]
