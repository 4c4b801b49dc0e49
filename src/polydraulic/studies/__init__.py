"""Studies: the thesis' chapters computed, drawn and reported.

`database` (random databases), `boom_models` (what is learnt), `single_link` (chapters 3 and 4: computation),
`single_link_figures` and `single_link_chapters` (what is shown), `flow_convergence` (flow models with volumes), `timing`,
`catalog` and `report` (how it is put together).
"""

from polydraulic.studies.database import CIRCUITS, boom_table, sample_boom
from polydraulic.studies.report import CHAPTERS, STEPS, write_report

__all__ = ["CHAPTERS", "CIRCUITS", "STEPS", "boom_table", "sample_boom", "write_report"]
