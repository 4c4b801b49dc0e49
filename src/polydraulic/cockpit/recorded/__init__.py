"""Drives as they were recorded: a tape of what was done at which step, files of tapes, a player that gives the same bits again."""
