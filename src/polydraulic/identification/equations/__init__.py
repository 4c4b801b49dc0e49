"""Numbers and curves of a machine, identified inside its known equations from what sensors read."""
