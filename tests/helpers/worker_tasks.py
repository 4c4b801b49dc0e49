"""Work for other processes, which find it by its module."""

import os
import warnings


def end_this_process(by):
    os.kill(os.getpid(), by)


def warned(item):
    warnings.warn(f"item {item}", stacklevel=1)
    return item
