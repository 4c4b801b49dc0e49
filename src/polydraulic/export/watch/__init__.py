"""A machine that is watched, as C99 and as an FMU."""
