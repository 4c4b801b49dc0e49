"""The tables of docs/measured_logs.md that tests are held to: `python tests/helpers/log_tables.py` writes them anew."""

from pathlib import Path

if __name__ == "__main__":
    import sys

    sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers import finding_kinds, group_log_kinds, log_kinds

PAGE = Path(__file__).parents[2] / "docs" / "measured_logs.md"


def tables():
    """The tables, each of which begins with a line that no other line of the page is like, and ends before a blank one."""
    return [module.documented() for module in (log_kinds, group_log_kinds, finding_kinds)]


def main():
    """Write the tables into the page."""
    text = PAGE.read_text(encoding="utf-8")
    for table in tables():
        marked = table.partition("\n")[0]
        before, _, rest = text.partition(marked)
        text = before + table + rest[rest.index("\n\n") + 1 :]
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
