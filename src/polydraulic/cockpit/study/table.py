"""The results of a study as one table: a row for each attempt, with what its subject answered at the end."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

from polydraulic.cockpit.study.course import ANSWER
from polydraulic.cockpit.study.plan import Study
from polydraulic.files import write_text

_OF_STUDY = ("task", "block", "practice", "repetition")
_OF_ATTEMPT = ("exercise", "mode", "pattern", "machine", "flow", "when", "finished")
_LETTERS = "abcdefghijklmnopqrstuvwxyz0123456789-"
_LONGEST = 60


def table_path(study: Study, folder: Path) -> Path:
    """Where the table of a study stands in the folder of results."""
    title = study.title.lower()
    name = "".join(c if c in _LETTERS else "_" for c in title)[:_LONGEST]
    if name.replace("_", " ") != title:  # another title may have become the same
        name += f"-{crc32(title.encode()):08x}"
    return folder / f"study-{name}.csv"


def study_rows(study: Study, results: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """All attempts of a study, oldest first.

    Parameters
    ----------
    study : Study
    results : sequence of mappings
        All that stands in the file of results.

    Returns
    -------
    list of dict
        ``subject``, ``task``, ``block``, ``practice``, ``repetition``, ``exercise``, ``mode``, ``pattern``, ``machine``, ``flow``, ``when``, ``finished``,
        ``skipped``, each value of the score with its unit (``time [s]``), and ``answer``, the last one of the subject.
    """
    own = [r for r in results if isinstance(r.get("study"), Mapping) and r["study"].get("title") == study.title]
    answers = {r.get("subject"): r["study"][ANSWER] for r in own if ANSWER in r["study"]}
    rows = []
    for result in own:
        of = result["study"]
        if ANSWER in of:
            continue
        row = {"subject": result.get("subject")} | {key: of.get(key) for key in _OF_STUDY}
        row |= {key: result.get(key, of.get(key)) for key in _OF_ATTEMPT} | {"skipped": bool(of.get("skipped"))}
        row |= {f"{name} [{pair[1]}]": pair[0] for name, pair in result["values"].items()}
        rows.append(row | {"answer": answers.get(result.get("subject"), "")})
    return rows


def write_study_table(study: Study, results: Sequence[Mapping[str, Any]], folder: Path) -> Path:
    """Write them as CSV, whole or not at all.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    rows, path = study_rows(study, results), table_path(study, folder)
    values = [name for name in dict.fromkeys(key for row in rows for key in row) if name != "answer"]
    text = io.StringIO()
    writer = csv.DictWriter(text, [*values, "answer"], restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, text.getvalue())
    return path
