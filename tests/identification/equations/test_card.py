import re

import pytest

from helpers.machine_log import machine_log
from polydraulic import InputError, load_machine
from polydraulic.identification import identify, write_identification_card
from polydraulic.identification.equations.free_runs import free_run_rows, free_runs


@pytest.fixture(scope="module")
def found():
    log = machine_log(120.0)
    return identify(
        log, load_machine("cat215b"), free=["functions.boom.valve.*", "functions.boom.pilot.*", "circuits.boom.pump.*"]
    )


def test_a_card_has_what_an_engineer_asks_for(found, tmp_path):
    path = tmp_path / "card.html"
    write_identification_card(found, path, units="field")
    page = path.read_text(encoding="utf-8")
    assert ": identified" in page
    assert "circuits.boom.pump.flow" in page
    assert page.count("data:image/svg+xml;base64,") == 1
    assert "in3/s" in page
    assert re.search(r"<td[^>]*>10 s</td>", page)
    assert "circuits.series: kept; none of its numbers is free" in page
    with pytest.raises(InputError, match=r"card.pdf: a card ends in .html"):
        write_identification_card(found, tmp_path / "card.pdf")


def test_the_true_machine_identified_drifts_as_little_as_it_did(found):
    runs, why = free_runs(found)
    assert why == ""
    assert [run.seconds for run in runs] == [1.0, 5.0, 10.0]  # no 30 s in a fifth of two minutes
    for run in runs:
        before, after = (next(d for d in side if d.name == "boom") for side in (run.before, run.after))
        assert after.median < 2.0 * before.median + 1e-3
    assert len(free_run_rows(runs)) == 3 * 4
