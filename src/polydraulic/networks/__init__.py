"""Polynomial abductive networks; usable without any hydraulics.

Read in this order: `nodes` (the polynomials), `moments` and `synthesis` (how a network grows), `table` (how it is
evaluated), `partition` (which network answers where), `regressor` and `regions` (the estimators), `model` and `model_file`
(what leaves training), `bounds` (what is proved of it), `dynamic` and `free_run` (models of logs), `adaptation`, `plot`.
"""

import importlib
from typing import TYPE_CHECKING, Any

from polydraulic.networks.bounds import Bounds, check_range, model_bounds, network_bounds
from polydraulic.networks.compiled import compiled
from polydraulic.networks.free_run import free_run
from polydraulic.networks.lags import Dynamics, Lag
from polydraulic.networks.model import Model, Variable, describe
from polydraulic.networks.model_file import dump_models, load_models, parse_models, save_models
from polydraulic.networks.partition import Split, grid
from polydraulic.networks.slopes import distance_outside, model_slopes
from polydraulic.networks.table import Network, NetworkTable, Node

if TYPE_CHECKING:
    from polydraulic.networks.adaptation import Adapter
    from polydraulic.networks.classifier import AbductiveClassifier
    from polydraulic.networks.dynamic import DynamicRegressor
    from polydraulic.networks.generator import Learnt, learn_from
    from polydraulic.networks.perceptron import PerceptronRegressor, hidden_unit_sweep
    from polydraulic.networks.regions import RegionRegressor
    from polydraulic.networks.regressor import AbductiveRegressor

# scikit-learn takes longer to import than a simulation takes to run: what needs it is imported when it is asked for.
_LEARNERS = {
    "AbductiveClassifier": "classifier",
    "AbductiveRegressor": "regressor",
    "Adapter": "adaptation",
    "DynamicRegressor": "dynamic",
    "Learnt": "generator",
    "PerceptronRegressor": "perceptron",
    "RegionRegressor": "regions",
    "hidden_unit_sweep": "perceptron",
    "learn_from": "generator",
}


def __getattr__(name: str) -> Any:
    if name in _LEARNERS:
        return getattr(importlib.import_module(f"{__name__}.{_LEARNERS[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "AbductiveClassifier",
    "AbductiveRegressor",
    "Adapter",
    "Bounds",
    "DynamicRegressor",
    "Dynamics",
    "Lag",
    "Learnt",
    "Model",
    "Network",
    "NetworkTable",
    "Node",
    "PerceptronRegressor",
    "RegionRegressor",
    "Split",
    "Variable",
    "check_range",
    "compiled",
    "describe",
    "distance_outside",
    "dump_models",
    "free_run",
    "grid",
    "hidden_unit_sweep",
    "learn_from",
    "load_models",
    "model_bounds",
    "model_slopes",
    "network_bounds",
    "parse_models",
    "save_models",
]
