"""`MachineEnv`: a task on one machine, as Gymnasium has environments."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from polydraulic.errors import InputError, SimulationError, briefly
from polydraulic.gym.arguments import FIRST_TIME, RENDER_MODES, arguments_of
from polydraulic.gym.episodes import Begun, Episodes
from polydraulic.gym.motion import motion_columns
from polydraulic.gym.observations import limits_seen, numbers_seen
from polydraulic.gym.patience import told_if_long
from polydraulic.gym.tasks.task import Number
from polydraulic.gym.varied import varied_machine
from polydraulic.gym.workspace import Workspace, workspace_of
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.simulator import Simulator

_ALONE = np.zeros(1, dtype=np.int64)


class MachineEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """A task on one machine; `gymnasium.make` builds it by the names that `polydraulic.gym` registers.

    Actions are levers from -1 to 1, shares of full lever in the order of the machine's functions, which hold for a period; beyond their
    ends they stand at them. `numbers` lists what an observation holds.

    Parameters
    ----------
    task : str
        ``"Reach"``, ``"Grade"`` or ``"PickPlace"``.
    machine : LayoutMachine, or name or path of a parameter set
    period : float, s
        Of a step, a whole number of steps of `dt`.
    dt : float, s
        Of the simulator.
    randomize : mapping from name to (low, high), optional
        Numbers of the machine that are drawn for every episode: ``"valve_gain"`` and ``"friction"`` (shares of its own, for each function),
        ``"dead_time"`` (s, on top of its own, for each function), ``"payload"`` (kg at the tip). `info` of `reset` says what was drawn.
    depth : float, m, optional
        Grade: height of the line; drawn if not given.
    load : float, kg, optional
        PickPlace: half the mass of the link with the tip if not given. It hangs there as a point mass, with its weight and its inertia.
    render_mode : str, optional
        ``"rgb_array"``.

    Attributes
    ----------
    numbers : tuple of Number
        Name, unit and meaning of each number of an observation.
    workspace : Workspace
        Where the machine can be.
    simulator : Simulator
        The machine itself, all of its outputs by name; of each episode another one where machines are drawn.

    Raises
    ------
    InputError
        What cannot be used.
    """

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES), "render_fps": 20}  # noqa: RUF012

    def __init__(
        self,
        task: str,
        machine: LayoutMachine | str | Path = "excavator_22t",
        *,
        period: float = 0.05,
        dt: float = 5e-3,
        randomize: Mapping[str, tuple[float, float]] | None = None,
        depth: float | None = None,
        load: float | None = None,
        render_mode: str | None = None,
    ) -> None:
        self._given = arguments_of(task, machine, dt, period, randomize, depth, load, render_mode)
        self.render_mode, given = render_mode, self._given
        self.metadata = self.metadata | {"render_fps": max(round(1.0 / period), 1)}
        with told_if_long(FIRST_TIME.format(given.machine.title)):
            self.simulator = Simulator(given.machine, dt=dt, load=given.load)
            self.workspace: Workspace = workspace_of(given.machine, self._settled, lines=given.task.lines, depth=depth)
        self._episodes = Episodes(given.task, self.workspace, 1, given.period, given.ranges)
        self._places = [self.simulator.place[name] for name in motion_columns(given.machine)]
        self.numbers: tuple[Number, ...] = tuple(numbers_seen(self.workspace, given.task))
        limits = limits_seen(self.numbers)
        self.observation_space = gymnasium.spaces.Box(-limits, limits, dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(given.machine.names),), np.float32)
        self._carried, self._begun = 0.0, False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode.

        Parameters
        ----------
        seed : int, optional
        options : dict, optional
            Reach: ``"target"``; PickPlace: ``"pick"`` and ``"place"``; (3,) m along the ground's axes. Drawn if not given.

        Returns
        -------
        observation : (n_number,) array
        info : dict
            ``"goal"``, (3,) m along the ground's axes, and what `randomize` has drawn.

        Raises
        ------
        InputError
            Options that cannot be used.
        """
        super().reset(seed=seed)
        draws = self.np_random.random(self._episodes.draws)[:, None]
        begun = self._episodes.begin(_ALONE, draws, options or {})
        self._start(begun)
        self._episodes.see(self._values(), _ALONE)
        told = {name: values[:, 0].copy() for name, values in begun.parameters.items()}
        return self._episodes.observe()[0], {"goal": self._episodes.aim()[0], **told}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Hold the levers for a period.

        Parameters
        ----------
        action : (n_function,) array
            Shares of full lever.

        Returns
        -------
        observation, reward, terminated, truncated, info
            As Gymnasium has it; `info` says where the tip is of what is asked, ``"is_success"`` and ``"diverged"``.

        Raises
        ------
        InputError
            Levers that are no finite numbers, or too many or few.
        """
        levers = checked_levers(action, self.action_space.shape or ())
        if not self._begun:
            raise InputError("no episode has begun; call reset first")
        values = self._values().copy()
        try:
            self.simulator.step(levers * self.workspace.lever, self._given.steps, load=self._hung())
            values = self._values()
        except SimulationError:
            values[:] = np.nan
        judged = self._episodes.step(values, levers[:, None])
        told = {name: value[0].item() for name, value in judged.told.items()}
        return self._episodes.observe()[0], float(judged.reward[0]), bool(judged.over[0]), False, told

    def render(self) -> np.ndarray | None:
        """Draw the machine and where its tip should be, (height, width, 3) of uint8; None without a render mode."""
        if self.render_mode is None:
            return None
        from polydraulic.gym.picture import machine_picture

        return machine_picture(self.workspace, self._episodes.motion.position[:, 0], self._episodes.aim()[0])

    def close(self) -> None:
        """End: further steps are refused."""
        self.simulator.close()

    def _start(self, begun: Begun) -> None:
        given, self._carried, self._begun = self._given, 0.0, True
        if given.ranges:
            own = {name: values[:, 0] for name, values in begun.parameters.items()}
            self.simulator.close()
            self.simulator = Simulator(varied_machine(given.machine, own), dt=given.dt, load=given.load)
        self.simulator.reset(begun.states[0])

    def _hung(self) -> dict[str, float] | None:
        """What hangs at the tip, if it has changed."""
        carried = self._episodes.carried()
        if carried is None or carried[0] == self._carried:
            return None
        self._carried = float(carried[0])
        return {"payload": self._carried}

    def _values(self) -> np.ndarray:
        return np.asarray(self.simulator.values[self._places][:, None])

    def _settled(self, states: np.ndarray, span: float) -> np.ndarray:
        found, n = states.copy(), round(span / self._given.dt)
        for state in found:
            self.simulator.reset(state)
            try:
                self.simulator.step(n=n)
                state[:] = self.simulator.state
            except SimulationError:
                state[:] = np.nan
        return found


def checked_levers(action: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Levers between their ends, of that shape, as float64.

    Raises
    ------
    InputError
        What are no finite numbers, or another shape.
    """
    try:
        found = np.asarray(action, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.full(1, np.nan)
    if found.shape != shape or not np.isfinite(found).all():
        raise InputError(f"action = {briefly(action)}: must be finite numbers from -1 to 1 of the shape {shape}")
    return np.clip(found, -1.0, 1.0)
