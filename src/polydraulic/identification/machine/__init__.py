"""Pump and valves of a whole machine as networks, from a log of its work: rows, learning, judging, card."""
