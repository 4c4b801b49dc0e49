"""Curves and numbers of circuits from rows of a log: squares, exact slopes, steps, knots, errors."""
