"""Channels of a log that contradict each other, whatever each says alone: signs, exchanges, units."""
