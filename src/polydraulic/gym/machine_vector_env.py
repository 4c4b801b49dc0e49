"""`MachineVectorEnv`: a task on many machines side by side, in one simulator."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from polydraulic.errors import InputError, briefly
from polydraulic.gym.arguments import FIRST_TIME, RENDER_MODES, arguments_of
from polydraulic.gym.episodes import Begun, Episodes
from polydraulic.gym.machine_env import checked_levers
from polydraulic.gym.motion import motion_columns
from polydraulic.gym.observations import limits_seen, numbers_seen
from polydraulic.gym.patience import told_if_long
from polydraulic.gym.tasks.task import Number
from polydraulic.gym.varied import varied_machine
from polydraulic.gym.workspace import Workspace, workspace_of
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.stepping.batch_simulator import BatchSimulator
from polydraulic.simulation.stepping.per_machine import count

_MOST = 1_000_000  # machines side by side
_SETTLED = 64  # machines that come to rest at a time, a block of lanes


class MachineVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """A task on many machines side by side; `gymnasium.make_vec` builds it by the names that `polydraulic.gym` registers.

    Machine i with seed s has the episodes of a `MachineEnv` with seed s + i, bit for bit.

    Parameters
    ----------
    task : str
    num_envs : int
    machine : LayoutMachine, or name or path of a parameter set
    max_episode_steps : int, optional
        Steps after which an episode is cut off.
    autoreset_mode : AutoresetMode or str
        Episodes that are over begin anew with the next step, whose action they ignore (``"NextStep"``), in the same step (``"SameStep"``,
        with ``final_obs`` and ``final_info`` in `info`), or by ``reset(options={"reset_mask": ...})`` alone (``"Disabled"``).
    threads : int
        That share the machines; results do not depend on it.
    period, dt, randomize, depth, load, render_mode
        As for `MachineEnv`. Machines of their own take some milliseconds of every episode to prepare.

    Attributes
    ----------
    numbers : tuple of Number
        Name, unit and meaning of each number of an observation.
    workspace : Workspace
        Where the machines can be.
    simulator : BatchSimulator
        The machines themselves, with the outputs that observations are made of.

    Raises
    ------
    InputError
        What cannot be used.
    """

    def __init__(
        self,
        task: str,
        num_envs: int = 1,
        machine: LayoutMachine | str | Path = "excavator_22t",
        *,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int = 1,
        period: float = 0.05,
        dt: float = 5e-3,
        randomize: Mapping[str, tuple[float, float]] | None = None,
        depth: float | None = None,
        load: float | None = None,
        render_mode: str | None = None,
    ) -> None:
        num_envs = count(num_envs, "num_envs", _MOST)
        given = self._given = arguments_of(task, machine, dt, period, randomize, depth, load, render_mode)
        try:
            self._mode = AutoresetMode(autoreset_mode)
        except ValueError as error:
            modes = [mode.value for mode in AutoresetMode]
            raise InputError(f"autoreset_mode = {briefly(autoreset_mode)}: must be one of {modes}") from error
        if max_episode_steps is not None and not max_episode_steps >= 1:
            raise InputError(f"max_episode_steps = {briefly(max_episode_steps)}: must be a whole number from 1 on")
        self._most, self.num_envs, self.render_mode = max_episode_steps, num_envs, render_mode
        self.metadata = {
            "render_modes": list(RENDER_MODES),
            "render_fps": max(round(1.0 / period), 1),
            "autoreset_mode": self._mode,
        }
        columns = motion_columns(given.machine)
        with told_if_long(FIRST_TIME.format(given.machine.title)):
            self.simulator = BatchSimulator(
                [given.machine] * num_envs if given.ranges else given.machine,
                num_envs,
                dt=dt,
                load=given.load,
                columns=columns,
                threads=threads,
                longest_delay=_longest(given.machine, given.ranges),
            )
            self.workspace: Workspace = workspace_of(given.machine, self._settled, lines=given.task.lines, depth=depth)
        self._outputs = [self.simulator[name] for name in columns]
        self._episodes = Episodes(given.task, self.workspace, num_envs, given.period, given.ranges)
        self.numbers: tuple[Number, ...] = tuple(numbers_seen(self.workspace, given.task))
        limits = limits_seen(self.numbers)
        self.single_observation_space = gymnasium.spaces.Box(-limits, limits, dtype=np.float32)
        self.single_action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(given.machine.names),), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._generators: list[np.random.Generator] = []
        self._ended = np.zeros(num_envs, dtype=bool)
        self._steps = np.zeros(num_envs, dtype=np.int64)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin episodes.

        Parameters
        ----------
        seed : int or sequence of int, optional
            Machine i gets ``seed + i``, or its own.
        options : dict, optional
            ``"reset_mask"``, (n,) of bool: those that begin, the others go on undisturbed; and what `MachineEnv.reset` takes, (3,) or a row for
            each that begins.

        Raises
        ------
        InputError
            What cannot be used.
        """
        rest = dict(options or {})
        mask = self._mask(rest.pop("reset_mask", None))
        super().reset(seed=int(seed) if isinstance(seed, int | np.integer) else None)
        self._seed(seed, mask)
        told = self._begin(mask, rest)
        return self._episodes.observe(), _masked(told, mask)

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Hold all levers for a period.

        Parameters
        ----------
        actions : (n, n_function) array
            Shares of full lever.

        Returns
        -------
        observations, rewards, terminations, truncations, infos
            As Gymnasium has it.

        Raises
        ------
        InputError
            Levers that are no finite numbers, or of another shape; machines whose episode is over, where they do not begin by themselves.
        """
        levers = checked_levers(actions, self.action_space.shape or ())
        new = self._ended.copy()
        if self._mode is AutoresetMode.DISABLED and new.any():
            raise InputError(
                f"episodes of machines {np.flatnonzero(new)[:8].tolist()} are over; begin them by reset(options={{'reset_mask': ...}})"
            )
        if not self._generators:
            raise InputError("no episode has begun; call reset first")
        carried = self._episodes.carried()
        hung = None if carried is None else {"payload": carried}
        self.simulator.step(levers * self.workspace.lever, self._given.steps, load=hung)
        judged = self._episodes.step(np.stack(self._outputs), levers.T)
        self._steps += 1
        rewards, over = judged.reward, judged.over
        cut = np.zeros(self.num_envs, dtype=bool) if self._most is None else self._steps >= self._most
        if new.any():
            rewards, over, cut = np.where(new, 0.0, rewards), over & ~new, cut & ~new
            infos = _masked(judged.told, ~new) | _masked(self._begin(new, {}), new)
        else:
            infos = _masked(judged.told, ~new)
        self._ended = over | cut
        if self._mode is AutoresetMode.SAME_STEP and self._ended.any():
            infos = self._begun_at_once(judged.told)
        return self._episodes.observe(), rewards, over, cut, infos

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Draw all machines, a picture each; None without a render mode."""
        if self.render_mode is None:
            return None
        from polydraulic.gym.picture import machine_picture

        shown = zip(self._episodes.motion.position.T, self._episodes.aim(), strict=True)
        return tuple(machine_picture(self.workspace, position, goal) for position, goal in shown)

    def close_extras(self) -> None:
        """End: further steps are refused, and threads end."""
        self.simulator.close()

    def _begun_at_once(self, told: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Begin the episodes that are over; infos with what was last seen and said of them."""
        over = self._ended.copy()
        final = np.full(self.num_envs, None, dtype=object)
        seen = self._episodes.observe()
        for i in np.flatnonzero(over):
            final[i] = seen[i]
        infos = _masked(told, ~over) | _masked(self._begin(over, {}), over)
        infos |= {"final_obs": final, "final_info": _masked(told, over)}
        return infos | {"_final_obs": over.copy(), "_final_info": over.copy()}

    def _begin(self, mask: np.ndarray, options: Mapping[str, Any]) -> dict[str, np.ndarray]:
        """Begin episodes where the mask says so; what is said of them, a row for each machine."""
        which = np.flatnonzero(mask)
        draws = np.stack([self._generators[i].random(self._episodes.draws) for i in which], axis=1)
        begun = self._episodes.begin(which, draws, options)
        self._place(mask, which, begun)
        self._episodes.see(np.stack(self._outputs)[:, which], which)
        self._steps[which], self._ended[which] = 0, False
        told = {"goal": self._episodes.aim()}
        for name, values in begun.parameters.items():
            told[name] = np.zeros((self.num_envs, len(values)))
            told[name][which] = values.T
        return told

    def _place(self, mask: np.ndarray, which: np.ndarray, begun: Begun) -> None:
        """Put machines where their episodes begin."""
        states = np.zeros((self.num_envs, begun.states.shape[1]))
        states[which] = begun.states
        machines = None
        if begun.parameters:
            machines = [self._given.machine] * self.num_envs
            for k, i in enumerate(which):
                own = {name: values[:, k] for name, values in begun.parameters.items()}
                machines[i] = varied_machine(self._given.machine, own)
        self.simulator.reset(mask, states, machines=machines)

    def _seed(self, seed: int | Sequence[int | None] | None, mask: np.ndarray) -> None:
        seeds: list[int | None]
        if seed is None:
            seeds = [None] * self.num_envs
        elif isinstance(seed, int | np.integer):
            seeds = [int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = [None if each is None else int(each) for each in seed]
        if len(seeds) != self.num_envs:
            raise InputError(f"seed has {len(seeds)} numbers: must be one number, or {self.num_envs}")
        if not self._generators:
            self._generators = [seeding.np_random(None)[0] for _ in seeds]
        for i in np.flatnonzero(mask):
            if seeds[i] is not None:
                self._generators[i] = seeding.np_random(seeds[i])[0]

    def _mask(self, mask: Any) -> np.ndarray:
        if mask is None:
            return np.ones(self.num_envs, dtype=bool)
        found = np.asarray(mask)
        if found.shape != (self.num_envs,) or found.dtype != bool or not found.any():
            raise InputError(
                f"options: reset_mask = {briefly(mask)}: must be {self.num_envs} values of bool, at least one of them True"
            )
        if not self._generators and not found.all():
            raise InputError("options: reset_mask: the first reset begins all episodes; leave it out")
        return found

    def _settled(self, states: np.ndarray, span: float) -> np.ndarray:
        found, given = states.copy(), self._given
        names = [column.name for column in columns_of(given.machine).columns[: states.shape[1]]]
        with BatchSimulator(given.machine, _SETTLED, dt=given.dt, load=given.load, columns=names) as still:
            for first in range(0, len(found), _SETTLED):
                part = found[first : first + _SETTLED]
                whole = np.tile(part[:1], (_SETTLED, 1))
                whole[: len(part)] = part
                still.reset(state=whole)
                still.step(n=round(span / given.dt))
                part[:] = np.stack([still[name] for name in names], axis=1)[: len(part)]
        return found


def _masked(told: Mapping[str, np.ndarray], mask: np.ndarray) -> dict[str, Any]:
    """Infos as Gymnasium has them: each array, zero elsewhere, and by its name after an underscore of which machines it speaks."""
    found: dict[str, Any] = {}
    for name, values in told.items() if mask.any() else ():
        found[name] = np.where(mask.reshape(-1, *[1] * (values.ndim - 1)), values, values.dtype.type(0))
        found[f"_{name}"] = mask.copy()
    return found


def _longest(machine: LayoutMachine, ranges: Mapping[str, tuple[float, float]]) -> float:
    """Dead time that any machine may come to have, s."""
    return max(f.pilot.dead_time for f in machine.functions) + ranges.get("dead_time", (0.0, 0.0))[1]
