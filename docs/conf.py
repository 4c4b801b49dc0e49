"""The documentation site: `make docs` builds docs/_build/html, and any warning ends it.

Pages are plain Markdown that reads as well on a forge, so they hold no directives. What only a site has is added here: the order of
pages, the source of the examples, and a reference page for each public name.
"""

import importlib
import json
import re
from pathlib import Path

import numpydoc.xref

import polydraulic

numpydoc.xref.DEFAULT_LINKS.clear()  # into other projects' sites, which a build without network cannot look up

DOCS = Path(__file__).parent
PACKAGES = [
    "polydraulic",
    *(f"polydraulic.{name}" for name in "networks flow control measure identification export plotting gym".split()),
]
PUBLIC = {
    package: sorted(getattr(importlib.import_module(package), "__all__", []), key=str.lower) for package in PACKAGES
}

# the pages below each page; a page that nobody names goes below background
NAVIGATION = {
    "index": ["guides", "examples", "api", "background"],
    "guides": [
        "your_machine", "simulation", "stepping", "control", "cockpit", "gym", "stability", "faults", "diagnosis", "flow_models", "export_machine", "extending", "measured_logs", "identify", "machine_from_a_log", "guide", "networks",
        "dynamic_models", "export",
    ],
    "background": ["equations", "figures", "benchmarks", "architecture"],
}  # fmt: skip
_named = {page for pages in NAVIGATION.values() for page in pages} | {"index"}
NAVIGATION["background"] += sorted({page.stem for page in DOCS.glob("*.md")} - _named)

project = "polydraulic"
author = "the polydraulic authors"
version = release = polydraulic.__version__
extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
]
exclude_patterns = ["_build", "_templates"]
highlight_language = "text"
myst_heading_anchors = 3

# reference: numpydoc docstrings, one page a name; `name` in a docstring becomes a link where there is such a thing
suppress_warnings = ["ref.ref"]  # labels of scikit-learn's documentation in docstrings that are inherited from it
default_role = "py:obj"
autodoc_typehints = "none"  # the docstrings say types, with shapes and units
autosummary_ignore_module_all = False
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
numpydoc_xref_param_type = True  # of types in docstrings, those that are public become links
numpydoc_xref_ignore = "all"
numpydoc_xref_aliases = {
    name: f"{package}.{name}"
    for package in PACKAGES
    for name in PUBLIC[package]
    if name[0].isupper() and not name.isupper()
}
nitpicky = True
nitpick_ignore_regex = [("py:obj", r".*"), ("py:class", r".*")]

html_theme = "pydata_sphinx_theme"
html_title = f"polydraulic {release}"
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_sidebars = {"index": [], "examples": []}
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "footer_start": [],
    "footer_end": [],
    "header_links_before_dropdown": 6,
}
copybutton_exclude = ".linenos, .gp, .go"


def _write_reference(folder: Path) -> None:
    """Write a page for each public package, from which autosummary makes one for each of its names; remove those of names that went."""
    folder.mkdir(exist_ok=True)
    pages = {}
    for package, names in PUBLIC.items():
        title, listed = f"{package}\n{'=' * len(package)}", "\n".join(f"   {name}" for name in names)
        summary = f".. autosummary::\n   :toctree: .\n\n{listed}"
        pages[package] = f"{title}\n\n.. automodule:: {package}\n   :no-members:\n\n{summary}\n"
    wanted = {*pages, *(f"{package}.{name}" for package, names in PUBLIC.items() for name in names)}
    for page in folder.glob("*.rst"):
        if page.stem not in wanted:
            page.unlink()
    for package, text in pages.items():
        page = folder / f"{package}.rst"
        if not page.exists() or page.read_text() != text:  # an untouched page is not read anew
            page.write_text(text)


def _notebook(path: Path) -> str:
    """Text and code of a notebook as Markdown, its headings below those of the page."""
    parts = []
    for cell in json.loads(path.read_text())["cells"]:
        source = "".join(cell["source"])
        code = cell["cell_type"] == "code"
        parts.append(f"```python\n{source}\n```" if code else re.sub(r"^#", "###", source, flags=re.MULTILINE))
    return "\n\n".join(parts)


def _shown(match: re.Match) -> str:
    """A link to an example that stands alone, with the example below it."""
    path = DOCS / match[1]
    source = _notebook(path) if path.suffix == ".ipynb" else f"```python\n{path.read_text()}```"
    return f"{match[0]}\n\n{source}"


def _complete(app, page: str, source: list[str]) -> None:
    """Add to a page what only the site shows."""
    text = re.sub(r"^\[[^]]+\]\((\.\./examples/[\w.]+)\)$", _shown, source[0], flags=re.MULTILINE)
    below = NAVIGATION.get(page, [])
    if page == "api":
        below = [f"reference/{package}" for package in PACKAGES]
    if below:
        text += "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(below) + "\n```\n"
    source[0] = text


def setup(app) -> None:
    """Write the reference's pages, and let the others be completed as they are read."""
    _write_reference(DOCS / "reference")
    app.connect("source-read", _complete)
