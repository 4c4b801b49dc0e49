"""Numbers that are to be found: as coordinates without bounds, and what is said of them afterwards."""
