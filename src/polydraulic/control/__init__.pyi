from .arm import joints_at
from .coordinated import ControlSettings, CoordinatedControl
from .lever_patterns import LeverPattern, lever_pattern
from .planning import check_path
from .references import TipPath, pick_and_place, straight_line, tip_path
from .runs import SensorErrors, run_controlled

__all__ = [
    "ControlSettings",
    "CoordinatedControl",
    "LeverPattern",
    "SensorErrors",
    "TipPath",
    "check_path",
    "joints_at",
    "lever_pattern",
    "pick_and_place",
    "run_controlled",
    "straight_line",
    "tip_path",
]
