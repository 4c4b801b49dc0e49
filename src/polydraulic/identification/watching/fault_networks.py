"""Networks that name faults, learnt from simulated faults of the machine that is watched; as files of data."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.networks.growth.classifier import AbductiveClassifier
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Variable
from polydraulic.networks.model.model_file import dump_models, parse_models
from polydraulic.parameters.deviations import ScheduledFault
from polydraulic.parameters.fault_catalogue import FaultKind, fault_catalogue, timed_faults
from polydraulic.parameters.faults import faulty_column
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import random_operator
from polydraulic.progress import Progress, quiet
from polydraulic.simulation.runs import simulate
from polydraulic.watch.blocks import starts_of
from polydraulic.watch.expected import Expected
from polydraulic.watch.naming import FaultNetworks, features, inputs_of
from polydraulic.watch.watch import FaultWatch
from polydraulic.watch.watched import Watched

OPERATORS = 3  # of each fault, each with a size of its own
_BEGINS, _LASTS = 10.0, 70.0  # s
_LIMIT = 1.1  # V: full travel of all spools
_STEP, _SHORT_STEP = 5e-3, 2.5e-3  # s; flow forces want the shorter one
_LAYERS = 3
_NAMED = 6
_FORMAT, _SCHEMA = "polydraulic fault networks", 1


def learn_fault_networks(
    of: Watched, expected: Expected, *, operators: int = OPERATORS, seed: int = 0, progress: Progress = quiet
) -> FaultNetworks:
    """Learn networks from faults of the watched machine, simulated: each in sizes between its usual ones, of operators of their own.

    Parameters
    ----------
    of : Watched
    expected : Expected
        Of its healthy work: noise of sensors, and by how much evidence is to be divided.
    operators : int
        Logs of each fault.
    seed : int
        Of operators, sizes and noise.
    progress : Progress, optional

    Raises
    ------
    InputError
        If fewer than three kinds of faults give an alarm that they could be learnt from.
    """
    # the machine is its own true one
    exact = expected._replace(offset=np.zeros_like(expected.offset), slow=np.zeros_like(expected.slow))
    plant, together = _sticky(of.machine), float(np.median(expected.together))
    rows, kinds = [], []
    faults = _faults(plant, of)
    for number in range(operators * len(faults)):
        progress("simulate faults", number, operators * len(faults))
        rng = np.random.default_rng([seed, number])
        fault, kind = faults[number % len(faults)]
        watch = FaultWatch(of, exact)
        log = _log(of, plant, exact.noise, _scheduled(fault, rng), rng)
        watch.judge(*log)
        if (seen := watch.seen) is not None:
            rows.append(features(of.directions, seen, together))
            kinds.append(kind)
    if len(set(kinds)) < 3:
        raise InputError(
            f"simulated faults gave alarms of {len(set(kinds))} kinds ({', '.join(sorted(set(kinds))) or 'none'}) by these sensors; "
            "networks that tell kinds of faults apart take three"
        )
    found = AbductiveClassifier(AbductiveRegressor(max_layers=_LAYERS)).fit(np.array(rows), np.array(kinds))
    inputs = [Variable(name) for name in inputs_of(of.directions)]
    models = found.estimator_.to_models(inputs, [Variable(str(kind)) for kind in found.classes_])
    link = np.column_stack([found.link_.coef_, found.link_.intercept_])
    return FaultNetworks(tuple(d.name for d in of.directions), tuple(models), link)


def _sticky(machine: LayoutMachine) -> LayoutMachine:
    """The machine with hysteresis declared, of nothing where it has none, so that its spools may stick."""
    return machine._replace(
        functions=tuple(
            f._replace(effects=f.effects._replace(hysteresis=f.effects.hysteresis or 0.0)) for f in machine.functions
        )
    )


def _faults(plant: LayoutMachine, of: Watched) -> list[tuple[FaultKind, str]]:
    """Faults of the catalogue that directions are watched for of, and their kinds."""
    kinds = {d.name: d.kind for d in of.directions}
    return [(fault, kinds[fault.name]) for fault in fault_catalogue(plant) if fault.name in kinds]


def _scheduled(fault: FaultKind, rng: np.random.Generator) -> ScheduledFault:
    """A fault in a size between its usual ones, either way where it goes both."""
    if not fault.sizes:
        return ScheduledFault(fault.name, None, _BEGINS)
    low, high = (end(map(abs, fault.sizes)) for end in (min, max))
    sign = -1.0 if min(fault.sizes) < 0.0 and rng.uniform() < 0.5 else 1.0
    return ScheduledFault(fault.name, sign * low * (high / low) ** rng.uniform(), _BEGINS)


def _log(
    of: Watched, plant: LayoutMachine, noise: dict[str, float], fault: ScheduledFault, rng: np.random.Generator
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Readings of the blocks of a simulated log, and when each begins."""
    timed = timed_faults(plant, [fault])
    longest = _SHORT_STEP if any(f.effects.flow_force for f in plant.functions) else _STEP
    every = int(np.ceil(of.shape.raster / longest - 1e-9))
    work = random_operator(int(rng.integers(2**31)), _BEGINS + _LASTS, limit=_LIMIT, functions=plant.names)
    run = simulate(plant, "exact", work, dt=of.shape.raster / every, every=every, faults=timed)
    time = run["time"]
    starts = starts_of(time, np.zeros(len(time)), of.shape)
    at = starts[:, None] + np.arange(of.shape.rows)
    readings = {}
    for column in of.columns:
        read = faulty_column(column, time, run[column], timed, {})
        readings[column] = (read + rng.normal(0.0, noise.get(column, 0.0), len(time)))[at]
    return readings, time[starts + of.shape.before]


def save_fault_networks(networks: FaultNetworks, path: str | Path) -> None:
    """Write networks to a file that ends in ``.json``, whole or not at all.

    Raises
    ------
    InputError
        Another ending, or a place that cannot be written.
    """
    data = {
        "format": _FORMAT,
        "schema": _SCHEMA,
        "directions": list(networks.directions),
        "link": networks.link.tolist(),
        "networks": json.loads(dump_models(networks.models)),
    }
    write_text(networks_ending(path), json.dumps(data, indent=1, allow_nan=False) + "\n")


def networks_ending(path: str | Path) -> Path:
    """Path of a file of networks, or an InputError."""
    path = Path(path)
    if path.suffix.lower() != ".json":
        raise InputError(f"{path}: a file of networks that name faults ends in .json")
    return path


def load_fault_networks(path: str | Path) -> FaultNetworks:
    """Read networks that name faults.

    Raises
    ------
    InputError
        Missing, damaged, or of another schema.
    """
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: cannot be read as networks that name faults ({error})") from error
    if not isinstance(data, dict) or data.get("format") != _FORMAT:
        raise InputError(f"{path}: holds no networks that name faults")
    if data.get("schema") != _SCHEMA:
        raise InputError(
            f"{path}: has schema {data.get('schema')!r}, this version reads {_SCHEMA}; learn the networks again"
        )
    models = parse_models(json.dumps(data.get("networks")), str(path))
    directions, link = data.get("directions"), _link(data.get("link"))
    if not (isinstance(directions, list) and all(isinstance(name, str) for name in directions)):
        raise InputError(f"{path}: damaged: directions must be a list of names")
    if link is None or link.shape != (len(models), len(models) + 1):
        raise InputError(f"{path}: damaged: link must be {len(models)} rows of {len(models) + 1} finite numbers")
    return FaultNetworks(tuple(directions), tuple(models), link)


def _link(data: Any) -> np.ndarray | None:
    """Finite numbers in rows of one length, or None."""
    try:
        link = np.array(data, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return link if link.ndim == 2 and np.isfinite(link).all() else None


def networks_for(
    networks: FaultNetworks | str | Path, of: Watched, expected: Expected, progress: Progress = quiet
) -> FaultNetworks:
    """Networks of what is watched; a file of them that is not there is learnt and written.

    Raises
    ------
    InputError
        Those of another machine, or of other sensors.
    """
    if isinstance(networks, FaultNetworks):
        return _checked(networks, of, "networks")
    if networks_ending(networks).exists():
        return _checked(load_fault_networks(networks), of, str(networks))
    found = learn_fault_networks(of, expected, progress=progress)
    save_fault_networks(found, networks)
    return found


def _checked(networks: FaultNetworks, of: Watched, source: str) -> FaultNetworks:
    """Networks, unless they were learnt for other faults than those that are watched."""
    names, inputs = tuple(d.name for d in of.directions), len(inputs_of(of.directions))
    if networks.directions == names and all(len(model.inputs) == inputs for model in networks.models):
        return networks
    other = sorted(set(networks.directions) ^ set(names))
    which = (
        f": {', '.join(other[:_NAMED])}{' and others' if len(other) > _NAMED else ''} are not of both" if other else ""
    )
    raise InputError(
        f"{source}: learnt for another machine, or other sensors, than those that are watched{which}; name a new file to learn networks for these"
    )
