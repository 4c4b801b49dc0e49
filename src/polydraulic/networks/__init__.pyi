from .adaptation import Adapter
from .dynamic.dynamic_regressor import DynamicRegressor
from .dynamic.free_run import free_run
from .dynamic.joint_regressor import JointRegressor
from .growth.classifier import AbductiveClassifier
from .growth.regressor import AbductiveRegressor as AbductiveRegressor
from .model.compiled import compiled
from .model.lags import Dynamics, JointStrength, Lag
from .model.model import Model, Variable, describe
from .model.model_file import dump_models, parse_models
from .model.model_file import load_models as load_models
from .model.model_file import save_models as save_models
from .model.partition import Split, grid
from .model.slopes import distance_outside, model_slopes
from .model.table import Network, NetworkTable, Node
from .perceptron.perceptron_regressor import PerceptronRegressor, hidden_unit_sweep
from .plot import draw_history, draw_network, draw_regions
from .proof.bounds import Bounds, check_range, model_bounds, network_bounds
from .regions.learn_from import Learnt, learn_from
from .regions.region_regressor import RegionRegressor as RegionRegressor

__all__ = [
    "AbductiveClassifier",
    "Adapter",
    "Bounds",
    "DynamicRegressor",
    "Dynamics",
    "JointRegressor",
    "JointStrength",
    "Lag",
    "Learnt",
    "Model",
    "Network",
    "NetworkTable",
    "Node",
    "PerceptronRegressor",
    "Split",
    "Variable",
    "check_range",
    "compiled",
    "describe",
    "distance_outside",
    "draw_history",
    "draw_network",
    "draw_regions",
    "dump_models",
    "free_run",
    "grid",
    "hidden_unit_sweep",
    "learn_from",
    "model_bounds",
    "model_slopes",
    "network_bounds",
    "parse_models",
]
