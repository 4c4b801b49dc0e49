"""Studies: what the thesis computes and what goes beyond it; `report` shows it.

`cache` (a lab that keeps what it has computed), `database` (random databases), `boom_models` and `boom_perceptrons` (what is
learnt of the boom), `circuit_models` (of all circuits), `single_link` (chapters 3 and 4), `flow_convergence` (flow models with
volumes), `timing`.
"""

from polydraulic.studies.cache import Lab, open_lab
from polydraulic.studies.database import CIRCUITS, boom_table, sample_boom, sample_series
from polydraulic.studies.report import CHAPTERS, write_figure, write_report

__all__ = [
    "CHAPTERS",
    "CIRCUITS",
    "Lab",
    "boom_table",
    "open_lab",
    "sample_boom",
    "sample_series",
    "write_figure",
    "write_report",
]
