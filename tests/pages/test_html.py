from xml.etree import ElementTree

from polydraulic.pages.html import document, table


def test_a_page_needs_nothing_else_and_its_title_is_a_text():
    page = document("a < b & c", "<p>body</p>")
    assert page.startswith("<!doctype html>")
    assert page.count("a &lt; b &amp; c") == 2
    assert "<p>body</p>" in page
    assert "{" in page.partition("<style>")[2].partition("</style>")[0]
    assert "http" not in page


def test_a_table_holds_its_texts():
    root = ElementTree.fromstring(table("x < y", ["a", "b"], [["1 & 2", "<i>"], ["", "4"]]))
    assert root.findtext("caption") == "x < y"
    assert [cell.text for cell in root.iter("th")] == ["a", "b"]
    assert [[cell.text or "" for cell in row] for row in root.find("tbody")] == [["1 & 2", "<i>"], ["", "4"]]
    assert "caption" not in table("", ["a"], [])
