"""How often 90 % intervals hold the truth of masses and friction from pressures, and of numbers found through simulation.

``python benchmarks/identify_intervals_others.py [MACHINE ...] [--logs N] [--first SEED]``: by pressures, masses and friction from five minutes of positions and
pressures; by runs, pilots, pumps and a mass from 35 s of commands and positions alone. Nothing was chosen by these seeds.
"""

import numpy as np

from identify_intervals import judge
from identify_sensors import JOINTS, begun, log_of
from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.base_parameters import base_parameters
from polydraulic.identification.equations.mechanics.fit import fit_mechanics, mechanical_spreads
from polydraulic.identification.equations.mechanics.inertia import inertial_values
from polydraulic.identification.equations.shooting.fit import fit_by_shooting
from polydraulic.identification.equations.shooting.windows import sensors_of

FREE = ("pilot.gain", "pilot.time_constant", "pump.flow")
SPREAD, OFF, OFF_INERTIA = 0.3, 0.15, 0.05


def prior_of(machine, rng):
    """A machine with other masses and friction, all of them possible."""
    truth = {number.path: number.value for number in machine.numbers}
    for _ in range(100):
        values = {
            path: truth[path] * np.exp((OFF_INERTIA if ".inertia." in path else OFF) * rng.normal())
            for path in mechanical_spreads(machine, SPREAD)
        }
        for f in machine.names:
            static, coulomb = (f"functions.{f}.friction.{name}" for name in ("static", "coulomb"))
            values[static] = max(values[static], 1.05 * values[coulomb])
        try:
            return machine.with_values(values)
        except InputError:
            continue
    raise SystemExit("no possible machine among a hundred")


def by_pressures(machine, seed):
    """The same of what motion determines of masses, and of friction."""
    prior = prior_of(machine, np.random.default_rng(seed))
    fit = fit_mechanics(log_of(machine, seed, 300.0), prior, mechanical_spreads(prior, SPREAD))
    base = base_parameters(machine)
    for b, true in zip(fit.base, base.combine @ inertial_values(machine, base.numbers), strict=True):
        if b.determined:
            yield "inertia and gravity", b.value - true, b.sd
    truth = {number.path: number.value for number in machine.numbers}
    for e in fit.estimates.numbers:
        if e.determined and ".friction." in e.path:
            yield e.path.split(".")[-1], e.value - truth[e.path], e.sd


def by_runs(machine, seed):
    """The same of pilots, pumps and the last link's mass."""
    paths = [n.path for n in machine.numbers if n.path.endswith(FREE)] + [f"links.{machine.tip[0]}.mass"]
    prior, spreads, truth = begun(machine, paths, np.random.default_rng(seed))
    log = log_of(machine, seed, 35.0)
    columns = [column for column in sensors_of(machine, log) if column.split(".")[-1] in JOINTS]
    for e in fit_by_shooting(log, prior, spreads, sensors=columns, seconds=1.0, most=32).estimates.numbers:
        if e.determined:
            yield e.path.split(".")[-1], e.value - truth[e.path], e.sd


if __name__ == "__main__":
    judge(__doc__.splitlines()[0], pressures=by_pressures, runs=by_runs)
