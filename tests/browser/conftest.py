"""One cockpit and one browser for all tests of this folder: `make test-browser`. Without a browser they are skipped, unless that target asks for it."""

import os

import pytest

from helpers.driven_page import BROWSER, DRIVER, DrivenPage, opened_browser, served_cockpit

MISSING = "needs chromium and chromedriver (Debian: apt-get install chromium chromium-driver)"


def pytest_collection_modifyitems(items):
    for item in items:
        if "browser" in item.path.parts[-2:-1]:
            item.add_marker(pytest.mark.browser)


@pytest.fixture(scope="session")
def recordings(tmp_path_factory):
    return tmp_path_factory.mktemp("recordings")


@pytest.fixture(scope="session")
def cockpit_url(recordings):
    if BROWSER is None or DRIVER is None:
        if os.environ.get("POLYDRAULIC_BROWSER") == "needed":
            pytest.fail(MISSING)
        pytest.skip(MISSING)
    with served_cockpit("cat215b", recordings) as url:
        yield url


@pytest.fixture(scope="session")
def browser(cockpit_url):
    with opened_browser() as browser:
        yield browser


@pytest.fixture(scope="session")
def opened(browser, cockpit_url):
    page = DrivenPage(browser, cockpit_url)
    page.open(
        "#flat"
    )  # a picture in space takes most of a computer without a graphics processor: tests of views ask for it
    return page


@pytest.fixture
def page(opened):
    """The page, the machine at its beginning, unlocked, all levers released."""
    opened.js("cockpit.levers.release(); window.padIn = false; document.getElementById('results').close()")
    opened.begin()
    yield opened
    opened.js("cockpit.levers.release()")
