"""Polynomial abductive networks; usable without any hydraulics.

Read in this order: `nodes` (the polynomials), `moments` and `synthesis` (how a network grows), `table` (how it is
evaluated), `partition` (which network answers where), `regressor` and `regions` (the estimators), `model` and `model_file`
(what leaves training), `bounds` (what is proved of it), `plot`.
"""

from polydraulic.networks.bounds import Bounds, check_range, model_bounds, network_bounds
from polydraulic.networks.classifier import AbductiveClassifier
from polydraulic.networks.compiled import compiled
from polydraulic.networks.generator import Learnt, learn_from
from polydraulic.networks.model import Model, Variable, describe
from polydraulic.networks.model_file import dump_models, load_models, parse_models, save_models
from polydraulic.networks.partition import Split, grid
from polydraulic.networks.perceptron import PerceptronRegressor, hidden_unit_sweep
from polydraulic.networks.regions import RegionRegressor
from polydraulic.networks.regressor import AbductiveRegressor
from polydraulic.networks.table import Network, NetworkTable, Node

__all__ = [
    "AbductiveClassifier",
    "AbductiveRegressor",
    "Bounds",
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
    "dump_models",
    "grid",
    "hidden_unit_sweep",
    "learn_from",
    "load_models",
    "model_bounds",
    "network_bounds",
    "parse_models",
    "save_models",
]
