"""What is reported of a log, as the documentation lists it."""

from polydraulic.measure.findings import KINDS

MARKED = "<!-- what is reported of a log -->"


def documented():
    """The table of the documentation."""
    rows = [f"| `{kind}` | {level} | {meaning} |" for kind, (level, meaning) in KINDS.items()]
    return (
        "\n".join([MARKED, "| finding | | what it means, and what was done about it |", "|---|---|---|", *rows]) + "\n"
    )
