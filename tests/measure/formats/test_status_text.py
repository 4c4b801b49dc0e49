import numpy as np
import pytest

from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.status_text import StatusNotes, StatusText, states


def texts(**names):
    return [StatusText(float(key[1:]), float(key[1:]), name) for key, name in names.items()]


@pytest.mark.parametrize(
    ("table", "scaled", "bits", "kept"),
    [
        (texts(v0="off", v1="on"), False, 8, [True, True]),
        (texts(v0="off", v1="on", v254="fault"), False, 8, [True, True, False]),
        (texts(v254="error", v255="none"), False, 8, [False, False]),
        (texts(v0="off", v1="on"), True, 8, [False, False]),  # a channel that measures, with a unit
        (texts(v0="off", v1="on"), True, 1, [True, True]),  # no value is left that could measure
        (texts(v0="off", v1="on", v2="Error", v3="not available"), True, 2, [True, True, False, False]),
        (texts(v0="ok", v1="error"), False, 1, [True, True]),  # the flag of an error
        (texts(v0="zero"), False, 8, [False]),
        ([StatusText(0, 5, "low"), StatusText(6, 9, "high")], False, 8, [False, False]),
    ],
)
def test_states_are_told_by_their_table(table, scaled, bits, kept):
    assert states(table, scaled=scaled, bits=bits) == kept


def test_a_finding_names_the_texts_of_all_blocks():
    findings = Findings()
    notes = StatusNotes("p", findings)
    notes.add(np.arange(1, 11), {})
    assert len(findings) == 0
    notes.add(np.arange(1, 11), {"error": np.array([3, 4])})
    notes.add(np.arange(11, 21), {"none": np.array([0]), "error": np.array([9])})
    (finding,) = findings.of("status", "p")
    assert finding.count == 4
    assert finding.rows == [(4, 5), (11, 11), (20, 20)]
    assert finding.detail == "'error', 'none'"
