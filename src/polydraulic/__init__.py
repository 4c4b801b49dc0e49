"""Simulate mobile hydraulic machines, and learn the parts of them that nobody can look into.

A run, with the flows of pump and valves in closed form and as polynomial abductive networks::

    from polydraulic import compare, simulate

    exact = simulate("cat215b", "exact", "task")
    networks = simulate("cat215b", "polynomial", "task")
    print(compare(exact, networks)["boom.angle"].largest)  # rad

Machines, scenarios and flow models go by name, by file, or as objects; numbers are in SI.

Simulate
    `simulate`, `simulate_batch` (many machines side by side), `reference`, `compare`, `run_summary`;
    `load_machine`, `load_scenario`, `random_operator`, `build_flow`.
Learn
    `AbductiveRegressor`, `RegionRegressor`, `load_models`, `save_models`; more in `polydraulic.networks`.
Tables
    `read_table`, `write_table`, `Table`.
Go on in
    `polydraulic.measure` (logs), `polydraulic.identification` (networks from logs), `polydraulic.export` (C, FMU, ONNX),
    `polydraulic.plotting`, `polydraulic.flow`.

``help(polydraulic.simulate)`` explains one name; ``polydraulic --help`` lists the commands; `docs/index.md` leads to everything else.
"""

# Names are loaded when first used, so that the import costs nothing; their list is the stub next to this file.
import logging

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

__version__ = "0.1.0"

logging.getLogger(__name__).addHandler(logging.NullHandler())  # a library prints nothing of its own accord
