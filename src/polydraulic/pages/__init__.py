"""HTML pages in one style: report, model cards, quality pages, documentation inside FMUs; tables as plain text."""
