"""Hostile files: each is read, or refused by an InputError, in bounded time and memory.

``python -m helpers.fuzz READER FIRST LAST`` from ``tests`` runs some of them alone.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from helpers.fuzz import READERS, REFUSED, RESULT

TESTS = Path(__file__).parents[1]


def outcomes(reader, first, last):
    """Outcomes in a process of its own: of the valid file, and of those of the numbers."""
    run = subprocess.run(
        [sys.executable, "-m", "helpers.fuzz", reader, str(first), str(last)],
        cwd=TESTS, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    found = [json.loads(line) for line in run.stdout.splitlines()]
    assert len(found) == (len(READERS) if reader == "all" else 1) * (1 + last - first)
    return [o for o in found if o[1] < 0], [o for o in found if o[1] >= 0]


def bad(found):
    return [outcome for outcome in found if outcome[2] not in (RESULT, REFUSED)]


def test_some_hostile_files_of_every_reader_are_read_or_refused():
    sound, found = outcomes("all", 0, 40)
    assert [outcome for outcome in sound if outcome[2] != RESULT] == []
    assert bad(found) == []
    kinds = {(reader, outcome) for reader, _, outcome, _ in found}
    assert {reader for reader, outcome in kinds if outcome == REFUSED} == set(READERS)  # the inputs are hostile,
    assert {reader for reader, outcome in kinds if outcome == RESULT} == set(READERS)  # and not noise


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_a_thousand_hostile_files_are_read_or_refused(reader):
    _, found = outcomes(reader, 24, 1024)
    assert bad(found) == []
