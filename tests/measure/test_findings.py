import numpy as np
import pytest

from helpers.log_tables import PAGE, tables
from polydraulic.errors import InputError
from polydraulic.measure.findings import SHOWN, Findings


def test_rows_that_follow_each_other_are_one_span_across_blocks():
    found = Findings()
    found.add_rows("spike", "p", np.array([3, 4, 9]))
    found.add_rows("spike", "p", np.array([10, 12]))
    (spike,) = found
    assert (spike.count, spike.rows) == (5, [(3, 4), (9, 10), (12, 12)])
    assert (
        str(spike)
        == "spike 'p' (5 rows) in rows 3 to 4, 9 to 10, 12: single values far from both neighbours; taken as missing"
    )


def test_all_rows_are_counted_and_the_first_spans_shown():
    found = Findings()
    found.add_rows("gap", "time", 2 * np.arange(3 * SHOWN) + 1)
    found.add_span("gap", "time", 1000, 2000, 7)
    (gap,) = found
    assert gap.count == 3 * SHOWN + 7
    assert gap.rows == [(k, k) for k in range(1, 2 * SHOWN, 2)]


def test_errors_stand_before_warnings_and_can_be_asked_for():
    found = Findings()
    found.add("constant", "a", "5 bar")
    found.add("empty", "b")
    found.add_rows("text", "c", np.array([], dtype=int))  # nothing
    assert [finding.level for finding in found] == ["error", "warning"]
    assert len(found) == 2
    assert [finding.channel for finding in found.of("constant")] == ["a"]
    assert found.of("constant", "b") == []
    with pytest.raises(InputError, match="no finding is called 'odd'"):
        found.of("odd")


@pytest.mark.parametrize("table", tables(), ids=lambda table: table.partition("\n")[0])
def test_the_documentation_lists_what_is_read_refused_and_reported(table):
    assert table in PAGE.read_text(encoding="utf-8"), "run python tests/helpers/log_tables.py"
