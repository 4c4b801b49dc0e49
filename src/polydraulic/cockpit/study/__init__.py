"""Studies with people: who tries what in which order, how far somebody has come, and all of it as one table."""
