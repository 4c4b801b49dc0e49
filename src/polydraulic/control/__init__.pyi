from .lever_patterns import LeverPattern, lever_pattern

__all__ = [
    "LeverPattern",
    "lever_pattern",
]
