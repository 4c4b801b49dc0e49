"""Watching a machine: what its sensors read against what the machine of a file would let them read, and what is wrong with it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
