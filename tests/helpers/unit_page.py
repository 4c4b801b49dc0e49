"""The list of units in docs/measured_logs.md, made of the table: `python tests/helpers/unit_page.py` writes it anew."""

from pathlib import Path

from polydraulic.unit_table import DOUBTFUL, DOUBTFUL_ALONE, KINDS

PAGE = Path(__file__).parents[2] / "docs" / "measured_logs.md"
BEGIN, END = "<!-- units: made by tests/helpers/unit_page.py -->\n", "<!-- end of units -->\n"


def listed():
    """A table of what is measured and in what, and one of what is refused."""
    lines = ["| measured | in the table | read as well |", "|---|---|---|"]
    for kind in KINDS:
        names = [name for texts in kind.symbols.values() for name in texts.split() if name not in DOUBTFUL_ALONE]
        others = [unit for unit in dict.fromkeys((*kind.offered, *names, *kind.products)) if unit != kind.si]
        lines.append(f"| {kind.name} | `{kind.si}` | {', '.join(f'`{unit}`' for unit in others)} |")
    lines += ["", "| refused | to be written as |", "|---|---|"]
    lines += [f"| `{text}` | {choice} |" for text, choice in DOUBTFUL.items()]
    lines += [f"| `{text}` alone | {choice} |" for text, choice in DOUBTFUL_ALONE.items()]
    return "\n".join(lines) + "\n"


def main():
    """Write the list into the page."""
    before, _, rest = PAGE.read_text().partition(BEGIN)
    PAGE.write_text(before + BEGIN + listed() + END + rest.partition(END)[2])


if __name__ == "__main__":
    main()
