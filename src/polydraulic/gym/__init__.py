"""Environments for Gymnasium: Reach, Grade and PickPlace on any machine, single and thousands side by side.

Importing it registers them::

    import gymnasium
    import polydraulic.gym

    env = gymnasium.make("polydraulic/Reach-v0", machine="wheel_loader")
"""

from importlib.util import find_spec

import lazy_loader

if find_spec("gymnasium") is None:
    raise ModuleNotFoundError(
        "gymnasium is not installed; environments need an extra: pip install 'polydraulic[gym]'", name="gymnasium"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

from polydraulic.gym.registered import register_tasks  # noqa: E402

register_tasks()
