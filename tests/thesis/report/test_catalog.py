"""Every number leads to the line that makes it."""

from importlib.resources import files

from polydraulic.thesis.report.catalog import printed_mm, printed_numbers, sources
from polydraulic.thesis.report.front import BEYOND, WITH_PRINTED


def test_every_printed_number_is_made_at_the_line_that_it_names():
    found = sources()
    assert set(printed_numbers()) <= set(found)
    for identity, place in found.items():
        path, line = place.split(":")
        text = (files("polydraulic").joinpath("..") / path).read_text(encoding="utf-8").splitlines()[int(line) - 1]
        assert f'"{identity}"' in text, place


def test_numbers_of_the_first_page_exist():
    assert set(WITH_PRINTED) <= set(printed_numbers())
    assert set(BEYOND) <= set(sources()) - set(printed_numbers())


def test_a_printed_length_in_millimetres():
    assert printed_mm("sim.task.end_effector_error_max_m") == "347"
