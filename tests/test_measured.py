"""Numbers in pages that a benchmark measured: none that is not in what it printed, as benchmarks/results keeps it."""

import json
import re
from decimal import Decimal

import pytest

from helpers.pages import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
MARKED = re.compile(r"<!-- measured: (\w+) -->\n(.*?)<!-- end of measured -->", re.DOTALL)
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*\w)")
BLOCKS = [(page.stem, name, text) for page in PAGES for name, text in MARKED.findall(page.read_text(encoding="utf-8"))]


def numbers(text):
    return [Decimal(found) for found in NUMBER.findall(text)]


def not_printed(text, printed):
    """Numbers of a text that no number printed is, rounded to as many digits."""
    return [
        a for a in numbers(text) if not any(abs(b - a) <= Decimal(5).scaleb(a.as_tuple().exponent - 1) for b in printed)
    ]


def kept(name):
    return json.loads((ROOT / "benchmarks" / "results" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("page", "name", "text"), BLOCKS, ids=[f"{page}-{name}-{n}" for n, (page, name, _) in enumerate(BLOCKS)]
)
def test_a_page_states_what_was_printed(page, name, text):
    assert len(numbers(text)) > 3
    printed = [number for line in kept(name)["printed"] for number in numbers(line)]
    assert not_printed(text, printed) == [], f"{page}: run python benchmarks/keep.py {name}, and state what it prints"


@pytest.mark.parametrize("name", sorted(path.stem for path in (ROOT / "benchmarks" / "results").glob("*.json")))
def test_what_is_kept_says_where_it_is_from(name):
    found = kept(name)
    assert found["command"].startswith(f"python benchmarks/{name}.py")
    assert (ROOT / "benchmarks" / f"{name}.py").is_file()
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", found["date"])
    assert found["commit"]
    assert found["machine"]


def test_a_number_that_was_not_printed_is_seen():
    printed = numbers("exact 0.7749 (0.771 to 0.779), 12 points, -3.5e-03")
    assert printed == [Decimal(one) for one in ("0.7749", "0.771", "0.779", "12", "-3.5e-03")]
    assert not_printed("0.77 times, 0.8; 12 points", printed) == []
    assert not_printed("0.76 of it, 0.7750, 13", printed) == [Decimal("0.76"), Decimal("0.7750"), Decimal("13")]
