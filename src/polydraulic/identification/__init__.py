"""From tables and logs to models, and how far they can be trusted: one function for each thing that a command does.

Read `table_fit`, `dynamic_fit`, `joint_fit` and `machine_fit` (what is learnt, and what is held out), `judging` (errors and intervals), `model_check` with
`validity` (does a model still hold), `runs` and `log_replay` (models and machines next to a log), `model_card`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
