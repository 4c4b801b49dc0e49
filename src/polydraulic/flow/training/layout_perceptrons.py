"""Perceptrons of the circuits of any machine, by the regions that deadbands and closing bypasses make; outlets as for polynomial networks.

They know all modes of the pump at once, up to just below its relief setting; valves behind others read the flow that reaches them.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.database import chosen_circuits
from polydraulic.flow.layout.slots import inlet
from polydraulic.flow.training.layout_models import (
    SEED,
    NetworkTarget,
    affordable,
    cuts_of,
    fed_target,
    learn_target,
    outlet_task,
)
from polydraulic.machine.pump import limited_pump
from polydraulic.networks.growth.far_values import far_values_untold
from polydraulic.networks.model.model import Model
from polydraulic.networks.perceptron.perceptron_regressor import PerceptronRegressor
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.layout.schema import LayoutMachine, SupplyCircuit
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet

BELOW_RELIEF = units.to_si(30.0, "psi")
ROWS = 10_000  # as many as the thesis used
HIDDEN_UNITS = 15  # thesis 4.3.1
REGIONS = 64  # at most


def train_layout_perceptrons(
    machine: LayoutMachine | str | Path,
    *,
    circuits: Sequence[str] | None = None,
    rows: int = ROWS,
    hidden_units: int = HIDDEN_UNITS,
    regions: int = REGIONS,
    progress: Progress = quiet,
) -> list[Model]:
    """Networks for the flow model ``"neural"`` of a machine, learnt from its exact circuits.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    circuits : sequence of str, optional
        Which of them; all if not given.
    rows : int
        Random points from which a network learns, and as many others at which its largest error is sought.
    hidden_units : int
        Sigmoids of a perceptron.
    regions : int
        Maximum number of regions of a network.
    progress : Progress, optional
        Told the output, and how many networks are done.

    Returns
    -------
    list of Model
        The largest error that was found of each stands in its ``training``.

    Raises
    ------
    InputError
        If there is no such circuit, it is not one of valves in series, or a number is not positive.
    """
    machine = as_machine(machine)
    outlets = [machine.function(f) for c in chosen_circuits(machine, circuits) for f in c.functions]
    n, total = len(outlets), 2 * len(outlets)
    inlets = inlet_perceptrons(
        machine,
        circuits=circuits,
        rows=rows,
        hidden_units=hidden_units,
        regions=regions,
        progress=lambda what, done, _: progress(what, done, total),
    )
    models = list[Model]()
    for f in outlets:
        progress(f"{f.name}.k_out", n + len(models), total)
        models.append(learn_target(outlet_task(f)))
    return models + inlets


def inlet_perceptrons(
    machine: LayoutMachine,
    *,
    circuits: Sequence[str] | None = None,
    rows: int = ROWS,
    hidden_units: int = HIDDEN_UNITS,
    regions: int = REGIONS,
    progress: Progress = quiet,
) -> list[Model]:
    """Those of inlets alone; arguments and errors as `train_layout_perceptrons`."""
    for name, value in (("rows", rows), ("hidden_units", hidden_units), ("regions", regions)):
        if value < 1:
            raise InputError(f"{name} = {value}: must be at least 1")
    chosen, rng, others = chosen_circuits(machine, circuits), *map(np.random.default_rng, (SEED, SEED + 1))
    targets = [(target, c.pump.flow) for c in chosen for target in inlet_targets(machine, c)]
    models = list[Model]()
    for target, high in targets:
        output, inputs = target.place
        progress(output.name, len(models), len(targets))
        low, up = np.transpose(target.box)
        X, unseen = (points.uniform(low, up, size=(rows, len(low))) for points in (rng, others))
        learner = PerceptronRegressor(
            hidden_units=hidden_units, domain=target.box, output_bounds=(0.0, high), random_state=SEED
        )
        with far_values_untold():
            found = RegionRegressor(learner, edges=affordable(target.edges, regions)).fit(X, target.function(X))
        model = found.to_model(inputs, output)
        largest = float(np.abs(model.predict(unseen) - target.function(unseen)).max())
        models.append(replace(model, training=model.training | {"largest_error": largest}))
    return models


def inlet_targets(machine: LayoutMachine, c: SupplyCircuit) -> list[NetworkTarget]:
    """Inlets of a circuit, counted from the pump: the first from all travels and pressures, the others from the flow that reaches them."""
    functions = [machine.function(name) for name in c.functions]
    valves, n, highest = [f.valve for f in functions], len(functions), c.pump.relief - BELOW_RELIEF
    pump = limited_pump(c.pump.flow, c.pump.relief, machine.tank.return_pressure, c.pump)
    travel = [(0.0, f.valve.knots[-1]) for f in functions]
    pressure = [(0.0, min(f.line.relief, highest)) for f in functions]
    first = NetworkTarget(
        inlet(c, c.functions[0])[-1],
        lambda X: sample_valves(valves, pump, X[:, :n], X[:, n:]).q_in[:, 0],
        [*travel, *pressure],
        {k: cuts_of(f) for k, f in enumerate(functions)},
    )
    return [first, *(fed_target(machine, c, place, highest, c.pump.relief) for place in range(1, n))]
