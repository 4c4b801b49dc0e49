from .dynamic_fit import DynamicFit, DynamicOutputFit, RunErrors, fit_dynamic
from .equations.card import write_identification_card
from .equations.identify import Identification, identify
from .equations.plan import IdentificationPlan, plan_identification
from .equations.residuals import Residual, ResidualModels, learn_residuals
from .joint_fit import fit_joints
from .judging import Errors, HeldOut, OutputFit
from .loads.payload_figure import plot_payload
from .loads.tip_loads import PayloadEstimate, TipForceEstimate, estimate_payload, estimate_tip_force
from .log_replay import Drift, Replay, Window, replay
from .machine.machine_card import Covered, machine_coverage
from .machine.machine_fit import MachineFit, fit_machine
from .model_card import write_card
from .model_check import Check, check_models
from .run_plot import plot_replay, plot_runs
from .runs import DynamicRun, ModelRuns, run_models
from .table_fit import TableFit, fit_table
from .validity import Validity
from .watching.watch_log import WatchedLog, watch_log
from .watching.watch_page import plot_watch, write_watch_page

__all__ = [
    "Check",
    "Covered",
    "Drift",
    "DynamicFit",
    "DynamicOutputFit",
    "DynamicRun",
    "Errors",
    "HeldOut",
    "Identification",
    "IdentificationPlan",
    "MachineFit",
    "ModelRuns",
    "OutputFit",
    "PayloadEstimate",
    "Replay",
    "Residual",
    "ResidualModels",
    "RunErrors",
    "TableFit",
    "TipForceEstimate",
    "Validity",
    "WatchedLog",
    "Window",
    "check_models",
    "estimate_payload",
    "estimate_tip_force",
    "fit_dynamic",
    "fit_joints",
    "fit_machine",
    "fit_table",
    "identify",
    "learn_residuals",
    "machine_coverage",
    "plan_identification",
    "plot_payload",
    "plot_replay",
    "plot_runs",
    "plot_watch",
    "replay",
    "run_models",
    "watch_log",
    "write_card",
    "write_identification_card",
    "write_watch_page",
]
