from .errors import InputError, SimulationError
from .flow.dispatch import build_flow
from .machine.stability.load_chart import LoadChart, load_chart
from .networks.growth.regressor import AbductiveRegressor
from .networks.model.model_file import load_models, save_models
from .networks.regions.region_regressor import RegionRegressor
from .parameters.deviations import Deviation, Fault, ScheduledFault
from .parameters.fault_catalogue import FaultKind, fault_catalogue
from .parameters.layout.schema import LayoutMachine
from .parameters.load import load_machine
from .parameters.scenario import Scenario, load_scenario, random_operator
from .progress import Progress
from .simulation.batch.batch import Batch, simulate_batch
from .simulation.layout.stability.monitor import Stability, StabilityMonitor
from .simulation.runs import reference, simulate
from .simulation.stepping.batch_simulator import BatchSimulator
from .simulation.stepping.saved import SavedBatch, SavedState
from .simulation.stepping.simulator import Simulator
from .simulation.summary import run_summary
from .simulation.trajectory import Difference, compare
from .tables import Table, read_table, write_table

__version__: str

__all__ = [
    "AbductiveRegressor",
    "Batch",
    "BatchSimulator",
    "Deviation",
    "Difference",
    "Fault",
    "FaultKind",
    "InputError",
    "LayoutMachine",
    "LoadChart",
    "Progress",
    "RegionRegressor",
    "SavedBatch",
    "SavedState",
    "Scenario",
    "ScheduledFault",
    "SimulationError",
    "Simulator",
    "Stability",
    "StabilityMonitor",
    "Table",
    "build_flow",
    "compare",
    "fault_catalogue",
    "load_chart",
    "load_machine",
    "load_models",
    "load_scenario",
    "random_operator",
    "read_table",
    "reference",
    "run_summary",
    "save_models",
    "simulate",
    "simulate_batch",
    "write_table",
]
