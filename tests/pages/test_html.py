"""Pages, tables and lists: everything that is passed in is escaped."""

import base64

import pytest

from polydraulic.pages.html import Cell, bullets, document, svg_image, table


def test_a_page_escapes_its_title_and_fits_any_screen():
    page = document("a < b", "<p>text</p>", top="<nav></nav>")
    assert "<title>a &lt; b</title>" in page
    assert "<h1>a &lt; b</h1>" in page
    assert 'name="viewport" content="width=device-width, initial-scale=1"' in page
    assert "@media print" in page
    assert "@media screen and (max-width" in page
    assert page.index("<nav>") < page.index("<h1>") < page.index("<p>text</p>")


def test_a_table_escapes_cells_and_names_them_for_narrow_screens():
    made = table("T & U", ["a", 'b "unit"'], [["<1>", Cell("2 < 3", "number")]])
    assert "<caption>T &amp; U</caption>" in made
    assert '<td data-name="a">&lt;1&gt;</td>' in made
    assert '<td class="number" data-name="b &quot;unit&quot;">2 &lt; 3</td>' in made
    assert "<caption>" not in table("", ["a"], [["1"]])


@pytest.mark.parametrize(
    ("columns", "cell", "wide"), [(4, "1.0", False), (5, "1.0", True), (3, "x" * 41, True), (2, "x" * 41, False)]
)
def test_rows_that_do_not_fit_a_narrow_screen(columns, cell, wide):
    made = table("", [str(k) for k in range(columns)], [[cell] * columns])
    assert ('<table class="wide">' in made) is wide
    assert ('<table class="wide">' in table("", [str(k) for k in range(columns)], [[Cell(cell, "number")] * columns])) is wide  # fmt: skip


def test_a_list_of_plain_texts():
    assert bullets(["a & b", "c"]) == "<ul><li>a &amp; b</li><li>c</li></ul>"
    assert bullets([]) == ""


def test_a_drawing_lies_in_the_page_with_its_words_escaped():
    made = svg_image("<svg/>", 'a & "b"')
    assert made == svg_image(b"<svg/>", 'a & "b"')
    assert base64.b64decode(made.split("base64,")[1].split('"')[0]) == b"<svg/>"
    assert 'alt="a &amp; &quot;b&quot;"' in made
