"""The files of the page: a fixed list, read once from the package."""

from importlib.resources import files
from typing import NamedTuple

_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
    ".json": "application/json",
    ".txt": "text/plain",
}


class PageFile(NamedTuple):
    """A file, and what a browser takes it for."""

    content: bytes
    type: str


def page_files() -> dict[str, PageFile]:
    """All files of the page by name; nothing else is ever served."""
    found = {}
    for entry in sorted((files("polydraulic.cockpit") / "page").iterdir(), key=lambda entry: entry.name):
        ending = f".{entry.name.rpartition('.')[2]}"
        if entry.is_file() and ending in _TYPES:
            found[entry.name] = PageFile(entry.read_bytes(), _TYPES[ending])
    return found
