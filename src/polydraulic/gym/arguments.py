"""Arguments of environments, checked: what both the single one and that of many machines are built of."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.gym.tasks.grade import grade_task
from polydraulic.gym.tasks.pick_place import pick_place_task
from polydraulic.gym.tasks.reach import reach_task
from polydraulic.gym.tasks.task import GymTask
from polydraulic.gym.varied import Ranges, checked_ranges, varied_machine
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

TASKS = ("Reach", "Grade", "PickPlace")
STEPS = {"Reach": 300, "Grade": 400, "PickPlace": 600}
"""Steps after which an episode is cut off: 15 s, 20 s and 30 s of 50 ms."""
FIRST_TIME = "{}: is being made ready; the first time, its machine is compiled, which takes up to a minute"
RENDER_MODES = ("rgb_array",)


class Arguments(NamedTuple):
    """What an environment is built of.

    Attributes
    ----------
    task : GymTask
    machine : LayoutMachine
        With a payload of 0 kg if payloads are drawn.
    steps : int
        Of the simulator in one of the environment.
    ranges : Ranges
    depth : float or None, m
    load : mapping or None
        What simulators are built with.
    """

    task: GymTask
    machine: LayoutMachine
    dt: float
    steps: int
    ranges: Ranges
    depth: float | None
    load: Mapping[str, float] | None

    @property
    def period(self) -> float:
        """Of a step of the environment, s."""
        return self.steps * self.dt


def arguments_of(
    task: str,
    machine: LayoutMachine | str | Path,
    dt: float,
    period: float,
    randomize: Mapping[str, tuple[float, float]] | None,
    depth: float | None,
    load: float | None,
    render_mode: str | None,
) -> Arguments:
    """Check them.

    Raises
    ------
    InputError
        What cannot be used.
    """
    if task not in TASKS:
        raise InputError(f"task = {briefly(task)}: must be one of {list(TASKS)}")
    if render_mode not in (None, *RENDER_MODES):
        raise InputError(f"render_mode = {briefly(render_mode)}: must be None or one of {list(RENDER_MODES)}")
    found, ranges = as_machine(machine), checked_ranges(randomize)
    steps = round(period / dt) if _within(period, 1e-6, 60.0) and _within(dt, 1e-6, 60.0) else 0
    if not (1 <= steps <= 10_000 and abs(steps * dt - period) < 1e-9 * period):
        raise InputError(
            f"period = {briefly(period)} s: must be a whole number of steps of dt = {briefly(dt)} s, up to 10000"
        )
    if depth is not None and (task != "Grade" or not _within(depth, -1e3, 1e3)):
        raise InputError(
            f"depth = {briefly(depth)} m: is the height of the line of Grade, a finite number; leave it out"
        )
    if load is not None and (task != "PickPlace" or not _within(load, 0.0, 1e6)):
        raise InputError(f"load = {briefly(load)} kg: is what PickPlace carries, from 0 to 1e6 kg; leave it out")
    if task == "PickPlace":
        of = pick_place_task(found.link(found.tip[0]).mass / 2.0 if load is None else float(load))
    else:
        of = grade_task() if task == "Grade" else reach_task()
    if "payload" in ranges:
        found = varied_machine(found, {"payload": np.zeros(1)})
    return Arguments(of, found, dt, steps, ranges, depth, {"payload": 0.0} if of.carries else None)


def _within(value: Any, low: float, high: float) -> bool:
    return isinstance(value, int | float | np.number) and bool(low <= value <= high)
