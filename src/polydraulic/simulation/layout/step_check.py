"""Whether a fixed step is small enough for a machine: its fastest oscillation of mass against oil, next to the step.

The semi-implicit step is stable while omega dt < 2. On cat215b_bucket, a random operator's tip is wrong in proportion to dt up to
omega dt = 0.76, and six times as much at 1.51: `DOUBTFUL` lies between.
"""

import numpy as np

from polydraulic._kernel import in_plain_python
from polydraulic.display import amount
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.prepare import ReadyMachine

DOUBTFUL = 1.0  # omega dt
USUAL = 0.4  # omega dt of 5 ms on that machine


def fastest_oscillation(machine: LayoutMachine, ready: ReadyMachine) -> float:
    """Highest eigenfrequency in rad/s of the joints on the oil of shut lines, where the machine starts; 0 where nothing is free.

    Of M(q) x'' + K x = 0 with K = a^2/C_a + b^2/C_b of each function, a and b what its two lines take in per radian or metre.

    Parameters
    ----------
    machine : LayoutMachine
    ready : ReadyMachine
        The machine, prepared for a step; locked functions count for nothing.
    """
    module, n = ready.module, len(machine.names)
    free = [k for k, locked in enumerate(ready.plant.locked) if not locked]
    if not free:
        return 0.0
    angles = module.Functions(*(f.initial.angle for f in machine.functions))
    position, times = (in_plain_python(kernel) for kernel in (module.position, module.times))
    here = position(angles, module.Functions(*[0.0] * n), ready.plant)
    columns = [times(here.motion.mass, module.Functions(*row)) for row in np.eye(n).tolist()]
    mass = np.array(columns)[np.ix_(free, free)]
    levers = zip(here.levers.a, here.levers.b, machine.functions, strict=True)
    stiffness = np.array([a**2 / f.line.compliance_a + b**2 / f.line.compliance_b for a, b, f in levers])[free]
    # Eigenvalues of M^-1 K as those of a symmetric matrix; SciPy has them at once, and takes long to import.
    half = np.linalg.inv(np.linalg.cholesky(mass))
    return float(np.sqrt(np.linalg.eigvalsh(half @ np.diag(stiffness) @ half.T)[-1]))


def step_warnings(machine: LayoutMachine, ready: ReadyMachine, dt: float) -> list[str]:
    """Say that a step is too large for a machine, and what would be usual; an empty list if it is not.

    Parameters
    ----------
    machine : LayoutMachine
    ready : ReadyMachine
    dt : float, s
    """
    omega = fastest_oscillation(machine, ready)
    if omega * dt <= DOUBTFUL:
        return []
    period = amount(2.0 * np.pi / omega, "s")
    return [
        f"dt = {dt:g} s is large for this machine, whose oil and masses oscillate with periods down to {period}: expect large errors; "
        f"usual is {amount(USUAL / omega, 's')} or less"
    ]
