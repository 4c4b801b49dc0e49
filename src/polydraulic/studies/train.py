"""Train the networks that come with the package: ``python -m polydraulic.studies.train FILE``.

The circuit of Eqs (1)-(3) is learnt without its relief valve, up to the relief pressure, from a seeded database; the
same seed and versions give the same file. At a dead-headed actuator these networks therefore go on delivering until the
line relief opens.
"""

import sys

import numpy as np

from polydraulic.networks import save_models
from polydraulic.parameters import load_machine
from polydraulic.studies.boom_models import SEED, fit_boom

if __name__ == "__main__":
    machine = load_machine("cat215b")
    models = fit_boom(machine, np.random.default_rng(SEED), pressure_high=machine.pumps.relief)
    save_models([models.q_in, models.q_out], sys.argv[1])
