"""What the thesis computed, computed again, and what goes beyond it; `report` shows it.

`cache` (a lab that keeps what it has computed), `boom_models` and `boom_perceptrons` (what is learnt of the boom), `single_link`
(chapters 3 and 4), `three_links` (5), `flow_convergence` (flow models with volumes), `beyond`, `measured` and `adaptation_study`.
"""
