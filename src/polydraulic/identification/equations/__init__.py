"""A machine whose equations are known, identified from what sensors read of it."""
