"""Pages made of a few rows and figures, without computing anything."""

from html import unescape

import pytest

from polydraulic.thesis.report.catalog import Chapter, Content, Grid, Paragraph
from polydraulic.thesis.report.front import STORY, front_page, headlines
from polydraulic.thesis.report.page import Shown, chapter_page, data_name, numbers_html
from polydraulic.thesis.report.write import CHAPTERS

SHOWN = Shown("Flows & <speeds>", "They agree.", ["a", "volume and delay"], 9.6)


def row(identity, computed, thesis=None, unit="m"):
    place = "polydraulic/thesis/report/chapters/chapter_5.py:7"
    return {"id": identity, "section": "5", "quantity": f"<{identity}>", "unit": unit, "thesis": thesis, "computed": computed,
            "note": "a & b", "source": place}  # fmt: skip


ROWS = [
    row("sim.task.end_effector_error_max_m", 0.3141, 0.347),
    row("table_4.rows.1.reduction_percent", -12.4, 26.54, "%"),
    row("polydraulic.sim.task.end_effector_error_max_m", 0.00712),
    row("polydraulic.operators.p95_m", 0.0561),
    row("polydraulic.operators.median_m", 0.0213),
    row("polydraulic.operators.largest_m", 0.123),
    row("polydraulic.time_of_a_step", 1.735, unit="1"),
]


def chapter(number):
    return Chapter(number, f"Part <{number}>", "About it.", lambda lab: Content([]), {"5-1": None})


def test_three_numbers_with_what_they_mean():
    task, operators, cost = headlines({r["id"]: r for r in ROWS})
    assert (task.value, operators.value, cost.value) == ("7.1 mm", "56 mm", "1.74 × exact")
    assert "314 mm" in task.means
    assert "347 mm" in task.means
    assert "21 mm" in operators.means
    assert "123 mm" in operators.means
    assert "saved 27 %" in cost.limits
    assert "take 12 % more" in cost.limits


def test_a_saving_is_called_one():
    saved = [r | {"computed": 12.4} if r["id"].startswith("table_4") else r for r in ROWS]
    assert "setting save 12 %" in headlines({r["id"]: r for r in saved})[-1].limits


@pytest.mark.parametrize("missing", [r["id"] for r in ROWS])
def test_a_number_whose_chapter_was_not_made_is_left_out(missing):
    assert len(headlines({r["id"]: r for r in ROWS if r["id"] != missing})) == 2


def test_the_first_page_has_the_story_before_the_tables_and_two_lists_of_chapters():
    page = front_page([chapter(5), chapter(7)], {"5-44": SHOWN, "5-12": SHOWN}, ROWS)
    assert page.index("<section>") < page.index('id="fig-5-44"') < page.index("<table") < page.index("<dl>")
    assert 'id="fig-5-12"' not in page  # not part of the story
    repeated, beyond = page.index("The thesis repeated"), page.rindex("Beyond the thesis, chapter by chapter")
    assert repeated < page.index('<li><a href="chapter_5.html"') < beyond < page.index('<li><a href="chapter_7.html"')
    assert "2 printed numbers" in page


def test_pictures_of_the_story_are_figures_of_chapters():
    assert {number for number, _ in STORY} <= {number for c in CHAPTERS.values() for number in c.figures}


def test_numbers_beyond_the_thesis_do_not_stand_under_printed_ones():
    both, beyond = numbers_html(ROWS), numbers_html(ROWS[2:])
    assert both.count("<table") == 2
    assert "Every printed number" in both
    assert "Further computed numbers" in both
    assert beyond.count("<table") == 1
    assert "printed" not in beyond
    assert "<th>thesis</th>" not in beyond
    assert "&lt;polydraulic.operators.p95_m&gt;" in beyond
    assert "chapter_5.py:7" in beyond


def test_a_chapter_lists_its_figures_and_escapes_what_it_says():
    content = Content([Paragraph("1 < 2", "Why & how.")], tables=[Grid("T", ["a"], [["<b>"]])])
    page = chapter_page(chapter(5), [chapter(5), chapter(7)], content, {"5-1": SHOWN, "5-2": SHOWN})
    for number in ("5-1", "5-2"):
        assert page.index(f'href="#fig-{number}"') < page.index(f'id="fig-{number}"')
    assert "<b>Why &amp; how.</b> 1 &lt; 2" in page
    assert "&lt;b&gt;" in page
    assert "Part &lt;5&gt;" in page
    assert "Flows &amp; &lt;speeds&gt;" in page
    assert "Flows & <" not in page
    assert '<a href="chapter_7.html">' in page
    assert '<a href="chapter_5.html">' not in page
    assert "Beyond the thesis" not in page
    assert "Beyond the thesis: Chapter 7" in unescape(chapter_page(chapter(7), [chapter(7)], content, {}))


def test_data_files_have_names_without_blanks():
    assert data_name("4-2", "a") == "fig_4-2a.csv"
    assert data_name("7-5", "volume and delay") == "fig_7-5_volume_and_delay.csv"
    assert data_name("3-2", "") == "fig_3-2.csv"
