"""Lift charts as pictures, text and pages."""

import pytest

from polydraulic import load_chart, load_machine
from polydraulic.plotting import draw_load_chart
from polydraulic.plotting.load_chart_figure import load_chart_page, load_chart_rows


@pytest.fixture(scope="module")
def machine():
    return load_machine("excavator_22t")


@pytest.fixture(scope="module")
def chart(machine):
    return load_chart(machine, step=2.0)


def test_a_picture_has_a_panel_for_each_direction_and_the_numbers_of_the_table(machine, chart):
    figure = draw_load_chart(machine, chart)
    titles = [axis.get_title(loc="left") for axis in figure.axes[:2]]
    assert titles == ["over the front", "over the side"]
    shown = {text.get_text() for text in figure.axes[1].texts}
    assert shown == {f"{value:.0f}" for value in chart.capacity[1].ravel() if value == value}


def test_text_names_what_limits(chart):
    header, *rows = load_chart_rows(chart, 1)
    assert header[:2] == ["height", "2000 mm"]
    cells = [cell for row in rows for cell in row[1:]]
    assert any(cell.endswith(" boom") for cell in cells)
    assert any(cell.endswith((" left", " right")) for cell in cells)
    assert "-" in cells
    assert float(rows[0][0].removesuffix(" mm")) > float(rows[-1][0].removesuffix(" mm"))


def test_units_of_people(chart):
    header, *rows = load_chart_rows(chart, 0, "field")
    assert header[1].endswith("in")
    assert float(rows[-1][2].split()[0]) > 1000.0


def test_a_page_holds_picture_and_both_tables(machine, chart):
    page = load_chart_page(machine, chart)
    assert page.count("<table") == 2
    assert "ISO 10567" in page
    assert "data:image/svg+xml;base64," in page
