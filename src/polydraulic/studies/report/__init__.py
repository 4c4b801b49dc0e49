"""The report: the thesis' chapters shown next to what this package computes.

`catalog` says what a chapter is; `chapter_*` and `figures_*` make them; `write` puts them into a folder; `page` is their HTML.
"""

from polydraulic.studies.report.write import CHAPTERS, write_figure, write_report

__all__ = ["CHAPTERS", "write_figure", "write_report"]
