"""polydraulic: polynomial abductive networks and real-time simulation of mobile hydraulic machines.

The names below are loaded when first used, so that importing the package, or asking the command line for help, costs nothing; the
list of names is the stub next to this file. `docs/api.md` is the whole public surface on one page.
"""

import logging

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

__version__ = "0.1.0"

logging.getLogger(__name__).addHandler(logging.NullHandler())  # a library prints nothing of its own accord
