"""A cockpit of its own process, and its page in Chromium without a screen."""

import re
import shutil
import subprocess
import sys
import time
from contextlib import contextmanager, suppress

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
_SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")  # WebGL where there is no graphics processor
_LONGEST = 60.0  # s that anything may take on a computer that is busy
# a gamepad as tests move it: browsers have no way to plug one in
_PAD = """
window.pad = {id: "a pad", index: 0, connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons: Array(17).fill({value: 0})};
window.padIn = false;
Navigator.prototype.getGamepads = () => (window.padIn ? [{...window.pad, axes: [...window.pad.axes]}, null] : [null, null]);
"""
# events that the page's own handlers get, as from a keyboard or a finger
_KEY = "document.body.dispatchEvent(new KeyboardEvent(arguments[0], {code: arguments[1], repeat: arguments[2], bubbles: true}))"
_TOUCH = """
const box = arguments[0].getBoundingClientRect(), [x, y] = arguments[2];
arguments[0].dispatchEvent(new PointerEvent(arguments[1], {pointerId: 7, pointerType: "touch", isPrimary: true, bubbles: true,
  clientX: box.left + box.width * (0.5 + 0.5 * x), clientY: box.top + box.height * (0.5 - 0.5 * y)}));
"""


@contextmanager
def served_cockpit(machine, folder, *options):
    """Start `polydraulic cockpit`; gives its URL, and ends it by Ctrl-C's signal."""
    command = ["cockpit", "--machine", machine, "--no-browser", "--port", "0", "--record", str(folder), *options]
    process = subprocess.Popen(
        [sys.executable, "-m", "polydraulic", *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    said = []
    try:
        for line in process.stdout:
            said.append(line)
            found = re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", line)
            if found:
                break
        else:
            raise AssertionError(f"the cockpit did not start: {''.join(said)}")
        yield found[0]
    finally:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(10.0)
        process.kill()
        process.wait()
        process.stdout.close()


@contextmanager
def opened_browser():
    """Chromium, driven by Selenium."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for argument in ("--headless=new", "--no-sandbox", *_SOFTWARE):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(DRIVER))
    try:
        browser.set_script_timeout(_LONGEST)
        browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": _PAD})
        yield browser
    finally:
        browser.quit()


class DrivenPage:
    """The page, as somebody uses it; times are those of the simulation, so that a slow picture changes nothing.

    Parameters
    ----------
    browser : selenium driver
    url : str
    """

    def __init__(self, browser, url):
        self.browser, self.url = browser, url

    def open(self, place=""):
        self.size(1280, 720)
        self.browser.get("about:blank")
        self.browser.get(self.url)
        if place:
            self.browser.get(self.browser.current_url + place)
            self.browser.refresh()
        self.until("return !!(window.cockpit && cockpit.frame)")

    def size(self, width, height):
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    def js(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def until(self, script, *arguments):
        """Wait until a script gives something true, and give that."""
        end = time.monotonic() + _LONGEST
        while time.monotonic() < end:
            found = self.js(script, *arguments)
            if found:
                return found
            time.sleep(0.02)
        told = self.js("return [cockpit.status, document.getElementById('notice').textContent]")
        raise AssertionError(f"still not so after {_LONGEST} s: {script} {arguments}: {told}")

    def click(self, selector):
        self.js("document.querySelector(arguments[0]).click()", selector)

    def press(self, text):
        """Click the button that says this."""
        self.js(
            "[...document.querySelectorAll('button')].find((one) => one.textContent === arguments[0]).click()", text
        )

    def key(self, code, down=True, repeat=False):
        self.js(_KEY, "keydown" if down else "keyup", code, repeat)

    def touch(self, selector, kind, place=(0.0, 0.0)):
        self.js(_TOUCH, self.browser.find_element("css selector", selector), kind, place)

    def status(self):
        return self.js("return cockpit.status")

    def until_status(self, name, value):
        self.until("return JSON.stringify(cockpit.status[arguments[0]]) === JSON.stringify(arguments[1])", name, value)

    def value(self, column):
        return self.js("return cockpit.readings.si(arguments[0])", column)

    def begin(self, pattern="iso", locked=False):
        """Drive from where the machine begins."""
        self.until_status("driver", "you")
        if self.status()["replay"]:
            self.click("#replay-bar [data-action=stop]")
            self.until_status("replay", None)
        self.click("#reset")
        self.until("return cockpit.status.locked && cockpit.frame.time < 1")
        self.click(f"[data-pattern={pattern}]")
        self.until_status("pattern", pattern)
        if not locked:
            self.click("#lock")
            self.until_status("locked", False)

    def positions(self):
        return dict(self.js("return cockpit.machine.functions.map((f) => [f.name, cockpit.readings.si(f.position)])"))

    def voltages(self):
        return dict(
            self.js("return cockpit.machine.functions.map((f) => [f.name, cockpit.readings.si(`${f.name}.voltage`)])")
        )

    def run_for(self, seconds):
        """Wait so long in simulated time."""
        end = self.js("return cockpit.frame.time") + seconds
        self.until("return cockpit.frame.time >= arguments[0]", end)

    def until_applied(self):
        """Wait until what the levers are has been applied by the simulation."""
        self.until("return cockpit.frame.seq === cockpit.connection.seq")

    def said(self):
        """What the browser's console has said, without news of graphics drivers."""
        return [
            line["message"] for line in self.browser.get_log("browser") if "GL Driver Message" not in line["message"]
        ]
