"""Episodes of one task on n machines side by side: all that an environment knows beside its simulator."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.gym.motion import Motion, motion_from
from polydraulic.gym.observations import limits_seen, numbers_seen, observation
from polydraulic.gym.tasks.task import GymTask, Judged, State
from polydraulic.gym.varied import Ranges, draw_count, parameters_from
from polydraulic.gym.workspace import Workspace


class Begun(NamedTuple):
    """Episodes that begin.

    Attributes
    ----------
    states : (m, n_state) array
        Of their machines.
    parameters : mapping from name to (n_number, m) array
        Those that are drawn, see `varied.VARIATIONS`.
    """

    states: np.ndarray
    parameters: dict[str, np.ndarray]


class Episodes:
    """Episodes of a task on n machines; arrays have a column for each.

    Parameters
    ----------
    task : GymTask
    workspace : Workspace
    n : int
    period : float, s
        Of a step.
    ranges : Ranges
        Of parameters that are drawn.

    Attributes
    ----------
    draws : int
        Uniform numbers that an episode begins with: an episode is a function of these.
    motion : Motion
        Machines after the last step.
    lost : (n,) array of bool
        Machines that have diverged in the last step; they are shown as they were before it.
    """

    def __init__(self, task: GymTask, workspace: Workspace, n: int, period: float, ranges: Ranges) -> None:
        n_function = len(workspace.machine.functions)
        self._task, self._workspace, self._period, self._ranges = task, workspace, period, ranges
        self._limits = limits_seen(numbers_seen(workspace, task))
        self.draws = task.draws + draw_count(ranges, n_function)
        self.motion = motion_from(np.zeros((5 * n_function + 3, n)))
        self.lost = np.zeros(n, dtype=bool)
        _, like = task.begin(workspace, np.zeros((task.draws, n)), {})
        self._state: State = {name: values.copy() for name, values in like.items()}

    def begin(self, which: np.ndarray, draws: np.ndarray, options: Mapping[str, Any]) -> Begun:
        """Begin episodes anew.

        Parameters
        ----------
        which : (m,) array of int
            Columns.
        draws : (draws, m) array
            From 0 to 1.
        options : mapping
            What the task may be told, one value for all or one for each of the m.

        Raises
        ------
        InputError
            Options that cannot be used; nothing has begun.
        """
        unknown = [name for name in options if name not in self._task.options]
        if unknown:
            raise InputError(
                f"options name {briefly(unknown[0])}; {self._task.name} takes {list(self._task.options) or 'none'}"
            )
        of_task = self._task.draws
        start, state = self._task.begin(self._workspace, draws[:of_task], options)
        for name, values in state.items():
            self._state[name][..., which] = values
        self.lost[which] = False
        n_function = len(self._workspace.machine.functions)
        return Begun(self._workspace.starts[start], parameters_from(self._ranges, n_function, draws[of_task:]))

    def see(self, values: np.ndarray, which: np.ndarray) -> None:
        """Take what machines that have begun look like: rows of `motion_columns`, a column for each of `which`."""
        for now, row in zip(self.motion, motion_from(values), strict=True):
            now[:, which] = row

    def step(self, values: np.ndarray, levers: np.ndarray) -> Judged:
        """Judge a step that has led to `values`, a column for each machine.

        Parameters
        ----------
        values : (5 n_function + 3, n) array
            Rows of `motion_columns`; nan for machines that have diverged.
        levers : (n_function, n) array
            Shares of full lever.
        """
        before, now = self.motion, motion_from(values)
        self.lost = ~np.isfinite(values).all(axis=0)
        if self.lost.any():
            now = Motion(*(np.where(self.lost, old, new) for old, new in zip(before, now, strict=True)))
        judged = self._task.judge(self._state, before, now, levers, self._period)
        self.motion = now
        told = {**judged.told, "is_success": judged.success & ~self.lost, "diverged": self.lost}
        return Judged(judged.reward, told["is_success"], judged.over | self.lost, told)

    def observe(self) -> np.ndarray:
        """Observations, (n, n_number) of float32."""
        return observation(self._workspace, self._task, self._state, self.motion, self._limits)

    def aim(self) -> np.ndarray:
        """Where the tips should be, (n, 3) m."""
        return np.array(self._task.aim(self._state).T)

    def carried(self) -> np.ndarray | None:
        """What hangs at the tips, (n,) kg, or None where nothing ever does."""
        return None if self._task.carried is None else self._task.carried(self._state)
