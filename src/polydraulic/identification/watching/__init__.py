"""A machine's log watched: what is wrong with the machine, since when, and how sure that is."""
