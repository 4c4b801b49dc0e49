"""The study that the thesis asked for: how much data of what quality buys what accuracy.

A random operator works on the exact machine, friction and end stops included, and sensors read it. Two ways lead from the same log to a machine:
networks in place of pump and valves, and the equations of the circuits with curves and numbers that are identified. Both are judged by operators
whom they never saw.
"""

import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, cpu_count, delayed

from polydraulic import units
from polydraulic.flow.dispatch import build_flow
from polydraulic.identification.equations.identify import identify
from polydraulic.identification.machine.machine_learning import learn, tasks_of
from polydraulic.identification.machine.machine_log import Known
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import load_scenario, random_operator
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import MISSING
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.measured.conditions import Conditions, conditions_in_words, machine_under
from polydraulic.thesis.measured.readings import log_of_readings, rows_for_networks, sensor_readings
from polydraulic.thesis.rough_machine import rough_machine
from polydraulic.thesis.three_links import SCENARIOS

JUDGES = tuple(range(4000, 4010))  # seeds of the operators who judge
JUDGE_SECONDS = 60.0


class WayErrors(NamedTuple):
    """Errors of a machine that one of the two ways led to, in the test runs.

    Attributes
    ----------
    flow_rms : dict from link to float
        Rms error of its input flow in in3/s, at the states that the judges' exact runs pass through.
    median, worst : float
        Of the largest end-effector errors in m of the operators who judge.
    scenarios : dict from name to float
        Largest end-effector error in m.
    outside : float
        Share of the steps of the judges' runs that leave what the log had: the domains of networks, or travel and pressure seen.
    """

    flow_rms: dict[str, float]
    median: float
    worst: float
    scenarios: dict[str, float]
    outside: float


class Outcome(NamedTuple):
    """What both ways reach from the same log.

    Attributes
    ----------
    rows : int
        In which all sensors gave something.
    networks : WayErrors or None
        None where sensors are missing that they need.
    identified : WayErrors
    """

    rows: int
    networks: WayErrors | None
    identified: WayErrors


def outcomes(lab: Lab, conditions: Sequence[Conditions]) -> list[Outcome]:
    """Measure, learn, identify and judge under each of some conditions, on all processors; kept by the lab, each as soon as it is there."""
    keys = {c: f"measured {_name(c)}" for c in conditions}
    missing = [c for c, key in keys.items() if not lab.computed.has_data(key)]
    n_jobs = min(len(missing), cpu_count()) or 1
    with warnings.catch_warnings():
        # joblib begins a worker anew whose memory has grown, which long logs make it do, and warns of it
        warnings.filterwarnings("ignore", message="A worker stopped while some jobs")
        made = Parallel(n_jobs=n_jobs, return_as="generator")(delayed(_made)(lab.machine, c) for c in missing)
        for number, c in enumerate(missing, 1):
            lab.say(f"learn from measurements, {number} of {len(missing)}: {conditions_in_words(c)}")
            lab.computed.data(keys[c], lambda: next(made))
    return [_outcome(*lab.computed.data(keys[c], list)) for c in conditions]


def _outcome(rows: int, networks: list[Any] | None, identified: list[Any]) -> Outcome:
    return Outcome(rows, None if networks is None else WayErrors(*networks), WayErrors(*identified))


def _made(machine: LayoutMachine, conditions: Conditions) -> list[Any]:
    true = machine_under(machine, conditions)
    read = sensor_readings(true, conditions)
    log = log_of_readings(read)
    start = rough_machine(true, np.random.default_rng(conditions.operator))
    learnt: list[tuple[LayoutMachine, Any]] = [(identify(log, start).machine, "exact")]
    if conditions.pressure_sensors and conditions.spool_sensors:
        tasks = tasks_of(true, Known.of(true), rows_for_networks(true, read))
        models = [model for (model,) in learn([(task,) for task in tasks])]
        learnt.append((true, build_flow("polynomial", true, models=models)))
    identified, *networks = (list(reached) for reached in reached_by(true, learnt))
    return [int(np.count_nonzero(log[MISSING] == 0.0)), networks[0] if networks else None, identified]


def _name(conditions: Conditions) -> str:
    return " ".join(f"{value:g}" if isinstance(value, float) else str(int(value)) for value in conditions)


def reached_by(true: LayoutMachine, learnt: Sequence[tuple[LayoutMachine, Any]]) -> list[WayErrors]:
    """Errors of machines and flow models where operators work: of flows at the states of the true machine's runs, and of the end-effector."""
    n = len(learnt)
    away, outside = np.empty((n, len(JUDGES))), np.empty((n, len(JUDGES)))
    squares = np.empty((n, len(JUDGES), len(LINKS)))
    for number, seed in enumerate(JUDGES):
        scenario = random_operator(seed, JUDGE_SECONDS)
        exact = simulate(true, "exact", scenario)
        spool, p_in, p_out, q_in = (
            exact.matrix([f"{link}.{name}" for link in LINKS]) for name in ("spool", "p_in", "p_out", "q_in")
        )
        for k, (machine, flow) in enumerate(learnt):
            run = simulate(machine, flow, scenario)
            away[k, number] = effector_distance(exact, run).max()
            outside[k, number] = int(str(run.info["steps_out_of_domain"])) / (len(run) - 1)
            squares[k, number] = np.mean((sample_flow(machine, flow, spool, p_in, p_out).q_in - q_in) ** 2, axis=0)
    rms = units.from_si(np.sqrt(squares.mean(axis=1)), "in3/s")
    scenarios: list[dict[str, float]] = [{} for _ in learnt]
    for name in SCENARIOS:
        scenario = load_scenario(name)
        exact = simulate(true, "exact", scenario)
        for found, (machine, flow) in zip(scenarios, learnt, strict=True):
            found[name] = float(effector_distance(exact, simulate(machine, flow, scenario)).max())
    return [
        WayErrors(
            dict(zip(LINKS, rms[k].tolist(), strict=True)),
            float(np.median(away[k])),
            float(away[k].max()),
            scenarios[k],
            float(outside[k].mean()),
        )
        for k in range(n)
    ]
