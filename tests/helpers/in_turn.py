"""Pairs of parameters of which the quick tests take as many as there are first ones."""

import pytest


def in_turn(firsts, seconds):
    """All pairs: each first one with the next of the second ones, round and round; the others are slow."""
    return [
        pytest.param(first, second, marks=[] if k % len(seconds) == place else pytest.mark.slow)
        for k, first in enumerate(firsts)
        for place, second in enumerate(seconds)
    ]
