"""`simulate`: a machine, a flow model and a scenario in, a table of named columns out."""

from collections.abc import Sequence
from pathlib import Path

from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.deviations import Fault, ScheduledFault, TimedFault
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.quantity import is_number
from polydraulic.parameters.scenario import Scenario
from polydraulic.simulation.layout.runs import simulate_layout
from polydraulic.simulation.steps import recorded_steps
from polydraulic.tables import Table

# methods of `simulate`, with the tolerance of those that choose their own steps
METHODS: dict[str, float | None] = {"semi-implicit": None, "rk4": None, "rosenbrock": 1e-4, "reference": 1e-9}


def simulate(
    machine: LayoutMachine | str | Path,
    flow: str | FlowModel,
    scenario: Scenario | str | Path,
    *,
    dt: float = 5e-3,
    t_end: float | None = None,
    every: int = 1,
    raster: float | None = None,
    method: str = "semi-implicit",
    rtol: float | None = None,
    energy: bool = False,
    forces: bool = False,
    stability: bool = False,
    faults: Sequence[str | Fault | ScheduledFault | TimedFault] = (),
) -> Table:
    """Simulate a scenario.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        The scenario's own pilots and initial state replace the machine's.
    flow : str or flow model
        Name of a flow model, or a model from one of the builders in `polydraulic.flow`.
    scenario : Scenario, or name or path of one
        What `load_scenario` takes.
    dt : float, s
        Time step; for the methods that choose their own steps, the raster of the result.
    t_end : float, s, optional
        Instead of the scenario's duration.
    every : int
        Record every so many steps.
    raster : float, s, optional
        Instead of `every`: record at these intervals, a whole number of steps.
    method : str
        ``"semi-implicit"``: one valve evaluation per step, bounded cost, for inputs not known in advance; voltages are held
        over a step. ``"rk4"``: classic Runge-Kutta, with flow models that keep nothing from step to step. ``"rosenbrock"``: steps of its own choice to the tolerance
        `rtol`, the fastest for inputs known in advance; needs flow ``"exact"``. ``"reference"``: an implicit solver with tight tolerances,
        slow, with the flow models of ``"rk4"``.
    rtol : float, optional
        Relative tolerance of the last two; 1e-4 and 1e-9 if not given.
    energy : bool
        Whether to add the energy account, see `simulation.layout.energy`.
    forces : bool
        Whether to add forces of actuators, friction and joint pins, see `simulation.layout.forces`.
    stability : bool
        Whether to add margins against tipping, see `simulation.layout.stability.columns`; the machine needs a chassis.
    faults : sequence of str, Fault, ScheduledFault or TimedFault
        Besides those of the scenario: ``"boom.pump_worn 10 % from 60 s"``; `fault_catalogue` has their names. Numbers change between two
        steps (``"rosenbrock"`` and ``"reference"``: at the very time), everything else goes on. Faults of sensors do not act here: a run is what
        the machine does, `record` what sensors read of it.

    Returns
    -------
    Table
        In SI. ``time``; of each function that moves, by its name, ``boom.voltage``, ``boom.spool``, ``boom.p_a``, ``boom.p_b``,
        ``boom.angle`` (``position`` where it slides), ``boom.rate``, ``boom.q_in``, ``boom.q_out``, ``boom.p_in``, ``boom.p_out``
        (of a locked one its angle alone); of each circuit ``series.q_pump``, ``series.q_bypass``, ``series.q_relief``, ``series.p_pump``, and
        between two valves ``series.p_between``; ``effector.x``, ``effector.y``, ``effector.z``. `info` counts the steps
        that did not converge and those outside the flow model's domain, and lists the ``events`` (see `events`).

    Raises
    ------
    InputError
        dt not positive, duration shorter than a step, a raster that is not a whole number of steps, an unknown flow model, a
        scenario that moves functions which the flow model does not serve, a fault that the machine cannot have.
    SimulationError
        If the run diverges, or a solver fails; says when and where.
    """
    machine = as_machine(machine)
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}; choose one of {list(METHODS)}")
    least = METHODS[method]
    if rtol is not None and (least is None or not is_number(rtol) or not 1e-13 <= rtol <= 0.1):
        raise InputError(
            f"rtol = {rtol} with method {method!r}: goes with 'rosenbrock' and 'reference', a number from 1e-13 to 0.1"
        )
    every = recorded_steps(dt, every, raster)
    return simulate_layout(
        machine, flow, scenario, dt=dt, t_end=t_end, every=every, method=method, rtol=rtol or least, energy=energy, forces=forces,
        stability=stability, faults=faults,
    )  # fmt: skip


def reference(
    machine: LayoutMachine | str | Path,
    flow: str | FlowModel,
    scenario: Scenario | str | Path,
    *,
    dt: float = 5e-3,
    rtol: float = 1e-9,
    t_end: float | None = None,
    faults: Sequence[str | Fault | ScheduledFault | TimedFault] = (),
) -> Table:
    """`simulate` with ``method="reference"``: the solution to a tight tolerance.

    Parameters
    ----------
    machine, flow, scenario, faults
        As for `simulate`.
    dt : float, s
        Raster of the result.
    rtol : float
        Relative tolerance of the solver.
    t_end : float, s, optional
        Instead of the scenario's duration.
    """
    return simulate(machine, flow, scenario, dt=dt, t_end=t_end, method="reference", rtol=rtol, faults=faults)
