"""Whoever moves the levers: `lever_patterns` says which stick moves what."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
