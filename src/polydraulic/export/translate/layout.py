"""Lines of C that are no longer than they need to be."""

WIDTH = 118
_LEAST = 30  # letters before a break
_BREAKS = (", ", " ? ", " : ", " || ", " && ", " + ", " - ", " * ", " / ")  # best first


def wrapped(text: str, indent: str) -> str:
    """Break a long line where its brackets are least nested, between things that belong together least."""
    lines, lead = [], indent
    while len(lead) + len(text) > WIDTH and (place := _break(text, WIDTH - len(lead))):
        lines.append(lead + text[:place].rstrip())
        text, lead = text[place:].lstrip(), f"{indent}        "
    return "\n".join([*lines, lead + text])


def _break(text: str, room: int) -> int:
    depth, best, found = 0, (99, 0), 0
    for place, letter in enumerate(text[:room]):
        depth += (letter in "([{") - (letter in ")]}")
        rank = next((rank for rank, mark in enumerate(_BREAKS) if text.startswith(mark, place)), None)
        if rank is not None and place > _LEAST and (depth, rank) <= best:
            best, found = (depth, rank), place + (rank == 0)
    return found
