"""The table of units agrees with itself, and the page lists it."""

import re

import pytest

from helpers.unit_page import BEGIN, END, PAGE, listed
from polydraulic.errors import InputError
from polydraulic.unit_table import BASE, DOUBTFUL, DOUBTFUL_ALONE, KINDS
from polydraulic.units import read_unit


def test_si_units_have_factor_one_and_the_base_that_the_table_says():
    for kind in KINDS:
        assert read_unit(kind.si)[:3] == (1.0, 0.0, kind.si), kind.name
        letters = " ".join(
            f"{letter}^{power:g}"
            for letter, power in zip(BASE, kind.base, strict=True)
            if 0 < abs(power) <= 3 and power == int(power)
        )
        if kind.si not in ("J", "N s/m", "m3/Pa", "m3/s/Pa", "V/s", "m3/s/Pa^0.5", "Pa^0.5"):
            assert read_unit(letters).si == kind.si, letters


def test_names_of_the_table_are_of_one_unit_each():
    names = [name for kind in KINDS for texts in kind.symbols.values() for name in texts.split()]
    assert len(names) == len(set(names))
    assert len({kind.name for kind in KINDS}) == len({kind.si for kind in KINDS}) == len(KINDS)
    for kind in KINDS:
        for unit in (*kind.offered, *kind.products):
            assert read_unit(unit).si == kind.si, unit
        for factor, texts in kind.symbols.items():
            for name in texts.split():
                if name not in DOUBTFUL_ALONE:
                    assert read_unit(name)[::2] == (factor, kind.si), name


def test_every_doubtful_text_is_refused():
    for text in (*DOUBTFUL, *DOUBTFUL_ALONE):
        with pytest.raises(InputError, match="can be read in several ways; write "):
            read_unit(text)


def test_the_page_lists_the_units_that_are_read():
    text = PAGE.read_text()
    assert BEGIN + listed() + END in text, "run python tests/helpers/unit_page.py"
    rows = [
        line.split(" | ") for line in text.partition(BEGIN)[2].partition(END)[0].splitlines() if line.count(" | ") == 2
    ]
    for _, si, others in rows[1:]:
        for unit in re.findall("`(.*?)`", others):
            assert read_unit(unit).si == si.strip("`"), unit
