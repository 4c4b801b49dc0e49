"""HTML pages in one style: report, model cards, quality pages, documentation inside of FMUs; tables as plain text."""
