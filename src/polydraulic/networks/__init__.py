"""Polynomial abductive networks; usable without any hydraulics.

Read in this order: `nodes` (the polynomials), `moments` and `synthesis` (how a network grows), `table` (how it is
evaluated), `partition` (which network answers where), `regressor` and `regions` (the estimators), `model` and `model_file`
(what leaves training), `proof` (what is proved of it), `dynamic` (models of logs), `adaptation`, `plot`.
"""

import lazy_loader

__getattr__, __dir__, _names = lazy_loader.attach_stub(__name__, __file__)

_HOME_ABOVE = {
    "AbductiveRegressor",
    "RegionRegressor",
    "load_models",
    "save_models",
}  # public as names of `polydraulic`
__all__ = [name for name in _names if name not in _HOME_ABOVE]
