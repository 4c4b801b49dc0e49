"""The step: why the end-effector is farthest off at the stick's end stop here, and at the end of the run in the thesis."""

from typing import NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.flow.dispatch import build_flow
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import load_scenario
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.thesis.excavator import with_pumps
from polydraulic.thesis.three_links import ThreeLinkStudy

PRINTED_ANGLE = np.radians(98.0)  # of the swing at 13 s, at which an error of 15.44 deg is one of 1.4 m along X alone
_HIGH = units.to_si(20_000.0, "psi")  # far above anything that the lines reach


class StepErrors(NamedTuple):
    """Networks in the thesis' setting less exact, after one change.

    Attributes
    ----------
    stops : float, s
        When the stick meets its end stop with the networks.
    swing_at_stop, swing_end : float, deg
        Of the swing at 5 s, where the exact stick meets its stop, and at 13 s.
    largest, time : float, m and s
        Of the end-effector, and when.
    along_x : float, m
        At 13 s.
    stick_flow : float, in3/s
        At 13 s.
    """

    stops: float
    swing_at_stop: float
    swing_end: float
    largest: float
    time: float
    along_x: float
    stick_flow: float


def step_causes(study: ThreeLinkStudy) -> dict[str, StepErrors]:
    """Errors of the step as it is run, and after each change."""

    def found() -> dict[str, list[float]]:
        study.lab.say("step: one change at a time")
        machine, models = study.machine(), study.historical()
        better = {model.output.name: model for model in shipped_models("direct")}
        follows = [better["stick.q_in"] if model.output.name == "stick.q_in" else model for model in models]
        end = float(study.run("step", "exact")["swing.angle"][-1])
        turned = _starting(machine, "swing", machine.function("swing").initial.angle + PRINTED_ANGLE - end)
        cases: dict[str, tuple[LayoutMachine, list[Model]]] = {
            "as run": (machine, models),
            "polydraulic's network for the stick": (machine, follows),
            "upper structure turned so that it ends at 98 deg": (turned, models),
            "both": (turned, follows),
            "the stick starts at its end stop": (
                _starting(machine, "stick", machine.function("stick").stops.high),
                models,
            ),
            "pump relief valve out of reach": (with_pumps(machine, relief=_HIGH), models),
        }
        return {name: [*_errors(*case)] for name, case in cases.items()}

    return {name: StepErrors(*values) for name, values in study.lab.computed.data("step causes", found).items()}


def _starting(machine: LayoutMachine, link: str, angle: float) -> LayoutMachine:
    """The machine with a link that starts at an angle in rad."""
    return machine.with_values({f"functions.{link}.initial.angle": angle})


def _errors(machine: LayoutMachine, models: list[Model]) -> StepErrors:
    scenario = load_scenario("step")
    exact = simulate(machine, "exact", scenario)
    run = simulate(machine, build_flow("polynomial", machine, models=models), scenario)
    away = effector_distance(exact, run)
    swing = np.degrees(run["swing.angle"] - exact["swing.angle"])
    events = run.info["events"]
    assert isinstance(events, list)
    met = [time for time, where, what in events if (where, what) == ("stick", "high stop met")]
    return StepErrors(
        float(met[0]),
        float(swing[int(np.searchsorted(exact["time"], 5.0 - 1e-9))]),
        float(swing[-1]),
        float(away.max()),
        float(exact["time"][int(np.argmax(away))]),
        float(run["effector.x"][-1] - exact["effector.x"][-1]),
        units.from_si(float(run["stick.q_in"][-1] - exact["stick.q_in"][-1]), "in3/s"),
    )
