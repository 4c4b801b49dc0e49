"""The chapters: numbers next to printed ones, and which figures there are."""
