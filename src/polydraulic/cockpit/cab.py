"""The machine that is driven: what the driver wants becomes voltages, steps are made, what is seen becomes a snapshot.

Nothing here knows a clock, so that the same wishes at the same steps give the same bits.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.cockpit.coordination import Coordination, coordination_of
from polydraulic.cockpit.exercises.catalogue import Exercise, exercises_of
from polydraulic.cockpit.exercises.trial import Observed, Trial
from polydraulic.cockpit.protocol import Flag
from polydraulic.cockpit.recorded.player import Player
from polydraulic.cockpit.recorded.tape import Tape, head_of
from polydraulic.cockpit.shadow import Shadow
from polydraulic.cockpit.tipping import Tipping
from polydraulic.cockpit.view import View
from polydraulic.cockpit.wanted import CabShown, ReplayShown, Taped, TrialShown, Wanted
from polydraulic.control.lever_patterns import PATTERNS, LeverPattern, lever_pattern
from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.deviations import Fault
from polydraulic.parameters.fault_catalogue import cockpit_faults
from polydraulic.parameters.faults import Since, faulty_numbers, stages, unknown_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.simulation.input_check import full_lever
from polydraulic.simulation.stepping.simulator import Simulator

DT = 5e-3  # s
_MOST_EVENTS = 32  # that a snapshot shows
_SOUGHT = 2000  # steps of a replay that are made at once on the way to another place


class Cab:
    """A machine and its levers.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str or flow model
    shadow : str or flow model, optional
        Another one that does the same in a state of its own, and each step once more from the state of the first one.

    Attributes
    ----------
    machine : LayoutMachine
        Without faults.
    name, source, flow : str
        `source` is where the machine is found again, the path of its file or the name of its set; empty if it was given as it is.
    simulator : Simulator
    patterns : mapping from name to LeverPattern
    coordination : Coordination or None
        None if the machine cannot be coordinated, or before `warm_up`; `uncoordinated` says why.
    exercises : mapping from name to Exercise
    faults : mapping from name to Fault
    view : View
    given_up : int
        Number of the last replay that could not go on.
    shown : CabShown
        What the machine does; replaced whole.
    """

    def __init__(
        self,
        machine: LayoutMachine | str | Path,
        flow: str | FlowModel = "exact",
        shadow: str | FlowModel | None = None,
    ) -> None:
        self.simulator = Simulator(machine, flow, dt=DT, load={"payload": 0.0})
        self.machine = self.simulator.machine
        given = str(machine) if isinstance(machine, str | Path) else ""
        self.source = str(Path(given).resolve()) if given.endswith(".toml") else given
        self.name = Path(given).stem if given else self.machine.title
        self.flow, self._model = flow if isinstance(flow, str) else flow.name, flow
        self.patterns: Mapping[str, LeverPattern] = {
            name: lever_pattern(self.machine, name, dead_zone=0.0) for name in PATTERNS
        }
        self.coordination: Coordination | None = None
        self.uncoordinated = "coordinated control is not ready"
        self.exercises: Mapping[str, Exercise] = exercises_of(self.machine, DT, layout_drawing(self.machine).ground)
        self.faults: Mapping[str, Fault] = {kind.name: kind.fault() for kind in cockpit_faults(self.machine)}
        self.shadow = None if shadow is None else Shadow(self.machine, shadow, DT)
        self.tipping = None if self.machine.chassis is None else Tipping(self.simulator)
        self.view = View(self.simulator, self.shadow, self.tipping)
        self.most_payload = 2.0 * sum(link.mass for link in self.machine.links)  # kg
        self._full = np.array([full_lever(f) for f in self.machine.functions])
        self._did = Wanted()  # wishes that have had their effect
        self._begun: dict[Fault, int] = {}  # step at which faults began
        self._stages: tuple[int, ...] = ()
        self._values: dict[str, float] = {}  # numbers that are not the healthy machine's
        self._payload, self._steps, self._outside, self._lost, self._coordinates = 0.0, 0, 0, False, False
        self._events: tuple[tuple[int, list[Any]], ...] = ()
        self._error, self._n_events = (0, ""), 0
        self._tape: Tape | None = None
        self._trial: Trial | None = None
        self._trial_shown: TrialShown | None = None
        self._player: Player | None = None
        self.given_up = 0
        self._sought = 0
        self.shown = self._snapshot(self._did, 0, 0.0)

    def warm_up(self) -> None:
        """Compile, or load, all that a step, another payload and coordinated control need; the machine is as before."""
        zero = np.zeros(len(self.simulator.names))
        self.coordination, self.uncoordinated = coordination_of(self.simulator, self.machine, self._model)
        if self.coordination is not None:
            self.coordination.warm_up()
        self.simulator.step(zero, 1, {"payload": 1.0})
        self.simulator.reset()
        if self.shadow is not None:
            self.shadow.step(zero, 1, 0.0)
        if self.tipping is not None:
            self.tipping.look(0.0)
        self._begin_anew()

    def move(self, wanted: Wanted, n: int, *, overruns: int = 0, rate: float = 0.0) -> None:
        """Make `n` steps as the driver wants, and show them."""
        self._obey(wanted)
        if self._player is not None:
            self._replay(wanted, n)
            self._steps += n
        elif not self._lost:
            self._drive(n, wanted)
        self.shown = self._snapshot(wanted, overruns, rate)

    def voltages(self, wanted: Wanted) -> np.ndarray:
        """What the levers give, V, in the order of the functions."""
        if wanted.locked:
            return np.zeros(len(self._full))
        return self.patterns[wanted.pattern].voltages(np.array(wanted.axes))

    def _drive(self, n: int, wanted: Wanted) -> None:
        """Make `n` steps by hand; where they are scored, one by one."""
        trial = None if self._trial is None or self._trial.over else self._trial
        coordination = None if wanted.locked or wanted.mode == "joint" else self.coordination
        if coordination is not None and not self._coordinates:
            coordination.begin()
        self._coordinates = coordination is not None
        volts, end = self.voltages(wanted), self._steps + n
        while self._steps < end:
            piece = end - self._steps if trial is None else 1
            known = wanted.payload if trial is None else trial.payload
            if coordination is not None:
                volts, piece = coordination.voltages(wanted, known, piece, self._since())
            self._steps += piece
            payload = known + unknown_payload(self._since())
            load = None
            self._trouble()
            if payload != self._payload:
                load, self._payload = {"payload": payload}, payload
                self._stamp(payload=payload)
            if (tape := self._recording) is not None:
                tape.levers(volts)
            before = self.simulator.steps
            try:
                self._make(volts, piece, load)
            except SimulationError as error:
                self._lost = True
                self._fail(f"{error}; reset begins anew")
            self._note_events()
            if tape is not None:
                tape.made(self.simulator.steps - before, self.simulator)
            if trial is not None:
                effort = float(np.sum((volts / self._full) ** 2))
                trial.observe(Observed(self.view.tip, effort, self.view.power, self.view.at_stop))
                self._show_trial()
            if self._lost:
                self._steps = end

    def _make(self, volts: np.ndarray, n: int, load: dict[str, float] | None) -> None:
        """Make steps; a shadow makes them too, and the last one also from where the machine is."""
        if self.shadow is None:
            self.simulator.step(volts, n, load)
            return
        if n > 1:
            self.simulator.step(volts, n - 1, load)
            self._note_events()
            self.shadow.step(volts, n - 1, self._payload)
            load = None
        state = self.simulator.state.copy()
        self.simulator.step(volts, 1, load)
        self.shadow.step_from(state, volts, self._payload, self.simulator.values, self.simulator.place)
        self.shadow.step(volts, 1, self._payload)

    def _replay(self, wanted: Wanted, n: int) -> None:
        """Make steps of a recorded drive."""
        player, wish = self._player, wanted.replay
        assert player is not None
        assert wish is not None
        try:
            if wish.seeks != self._sought:
                self._sought = wish.seeks
                if wish.step < player.step:
                    player.go_back(wish.step)
                self._shadow_begins()
            behind = wish.step - player.step if wish.seeks else 0
            if behind > 0:
                player.advance(min(behind, _SOUGHT))
                self._shadow_begins()
            elif wish.playing:
                made = player.advance(n)
                if self.shadow is not None and made:
                    self.shadow.step(player.levers, made, player.payload)
            self._note_events()
        except (InputError, SimulationError) as error:
            self._fail(str(error))
            self.given_up = wish.number
            self._player, self._stages = None, (-1,)
            self._payload, self._values = player.payload, dict(player.values)
            self._begin_anew()
            return
        self._payload, self._values = player.payload, dict(player.values)

    def _obey(self, wanted: Wanted) -> None:
        """Let wishes have their effect that have not had it yet."""
        did, self._did = self._did, wanted
        if wanted.recording != did.recording and (tape := self._recording) is not None:
            tape.end(self.simulator)
        if (wanted.replay and wanted.replay.number) != (did.replay and did.replay.number):
            self._turn_to(wanted, taken_over=wanted.taken_over != did.taken_over)
        if wanted.trial != did.trial:
            self._try(wanted)
        if wanted.resets != did.resets and self._player is None:
            self._begin_anew()
        if wanted.faults != did.faults:
            self._break(wanted.faults)
        if wanted.recording != did.recording and wanted.recording and self._player is None:
            head = head_of(self.simulator, self.source or self.name, self.flow, self._values)
            self._tape = Tape(wanted.recording, head)

    def _begin_anew(self) -> None:
        self.simulator.reset()
        self._payload, self._lost, self._outside, self._coordinates = 0.0, False, 0, False
        self._begun = dict.fromkeys(self._begun, 0)
        if self.tipping is not None:
            self.tipping.forget()
        self._stamp(reset=True)
        self._shadow_begins()

    def _turn_to(self, wanted: Wanted, *, taken_over: bool) -> None:
        """Begin or leave a replay."""
        if wanted.replay is None:
            self._player = None
            if not taken_over:
                self._begin_anew()
            self._stages = (-1,)  # faults of now, and not of then
            return
        if (tape := self._recording) is not None:
            tape.end(self.simulator)
        self._trial, self._sought, self._lost, self._coordinates = None, wanted.replay.seeks, False, False
        try:
            self._player = Player(wanted.replay.drive, self.simulator, self.machine)
            self._shadow_begins()
        except InputError as error:
            self._fail(str(error))
            self.given_up = wanted.replay.number

    def _try(self, wanted: Wanted) -> None:
        """Begin or end an exercise."""
        if wanted.trial is None:
            self._show_trial(running=False)
            self._trial = None
        elif self._player is None:
            self._begin_anew()
            self._trial = Trial(self.exercises[wanted.trial.name], wanted.trial.subject, DT)
            self._show_trial()

    def _break(self, names: tuple[str, ...]) -> None:
        """Let faults begin and end."""
        now = self.simulator.steps
        chosen = [self.faults[name] for name in names]
        self._begun = {fault: self._begun.get(fault, now) for fault in chosen}
        self._stages = (-1,)

    def _trouble(self) -> None:
        """Let the numbers of faults act whose time has come."""
        since = self._since()
        now = stages(since)
        if now == self._stages:
            return
        self._stages = now
        healthy = {number.path: number.value for number in self.machine.numbers}
        wanted = faulty_numbers(self.machine, since)
        changed = {path: healthy[path] for path in self._values} | wanted
        changed = {path: value for path, value in changed.items() if self._values.get(path, healthy[path]) != value}
        if not changed:
            return
        try:
            self.simulator.change(changed)
        except InputError as error:
            self._fail(f"this fault cannot be here: {error}")
            self._begun = {}
            return
        self._values = {
            path: value for path, value in (self._values | wanted | changed).items() if value != healthy[path]
        }
        self._stamp(change=changed)
        if self.shadow is not None:
            self.shadow.change(changed)

    @property
    def _recording(self) -> Tape | None:
        """The tape that runs."""
        return None if self._tape is None or self._tape.ended else self._tape

    def _since(self) -> Since:
        """How long faults have been there, s."""
        return [(fault, (self.simulator.steps - begun) * DT) for fault, begun in self._begun.items()]

    def _stamp(self, **what: Any) -> None:
        if (tape := self._recording) is not None:
            tape.put(**what)

    def _shadow_begins(self) -> None:
        if self.shadow is not None:
            self.shadow.begin(self.simulator.state, self._player.values if self._player else self._values)

    def _note_events(self) -> None:
        for event in self.simulator.events:
            self._tell(event)

    def _tell(self, event: list[Any]) -> None:
        self._n_events += 1
        self._events = (*self._events, (self._n_events, event))[-_MOST_EVENTS:]

    def _look_for_tips(self) -> None:
        """Say when a tip is foreseen, when the machine tips, and when neither is so any more."""
        tipping = self.tipping
        if tipping is None:
            return
        tipping.guard(self.coordination.tip_share if self.coordination and self._coordinates else 1.0)
        before = tipping.over, tipping.warning
        if not tipping.look(self._payload):
            return
        now = tipping.over, tipping.warning
        if now != before:
            what = "tips" if tipping.over else "may tip" if tipping.warning else "stands safely again"
            self._tell([self.simulator.time, "chassis", f"{what} {tipping.direction}" if tipping.warning else what])

    def _fail(self, text: str) -> None:
        self._error = (self._error[0] + 1, text)

    def _show_trial(self, *, running: bool = True) -> None:
        trial, wish = self._trial, self._did.trial
        if trial is None:
            return
        before = self._trial_shown
        score = trial.score()
        if not self.view.knows_power:
            score["actuator_energy"] = score.pop("energy")
        number = wish.number if wish else before.number if before else 0
        self._trial_shown = TrialShown(
            number, trial.exercise.name, trial.subject, self._did.mode, self._did.pattern, self._did.guarded,
            running and not trial.over, trial.done, score,
        )  # fmt: skip

    def _snapshot(self, wanted: Wanted, overruns: int, rate: float) -> CabShown:
        sim, view, tape, trial, player = self.simulator, self.view, self._tape, self._trial, self._player
        aims = trial is not None and not trial.over
        outside = sim.steps_out_of_domain + (self.shadow.outside if self.shadow else 0)
        conditions = {
            Flag.LOCKED: wanted.locked,
            Flag.RELIEF: view.relieved,
            Flag.STOP: bool(view.at_stop.any()),
            Flag.OUTSIDE: outside > self._outside,
            Flag.RECORDING: self._recording is not None,
            Flag.REPLAY: player is not None,
            Flag.TARGET: aims,
        }
        self._outside = outside
        self._look_for_tips()
        conditions |= self.tipping.conditions if self.tipping else {}
        return CabShown(
            steps=self._steps,
            seq=wanted.seq,
            time=sim.time,
            overruns=overruns,
            flags=sum(flag for flag, holds in conditions.items() if holds),
            values=view.values(self._payload, trial.target if trial is not None and aims else None),
            rate=rate,
            events=self._events,
            payload=self._payload,
            faults=tuple(fault.name for fault in self._begun),
            error=self._error,
            shadow=self.shadow.lost if self.shadow else "",
            taped=None if tape is None else Taped(tape.number, tape.first, tape.blocks, tape.ended),
            trial=self._trial_shown,
            replay=self._replay_shown(wanted),
        )

    def _replay_shown(self, wanted: Wanted) -> ReplayShown | None:
        if self._player is None or wanted.replay is None:
            return None
        player, playing = self._player, wanted.replay.playing and not self._player.ended
        return ReplayShown(wanted.replay.number, player.drive.name, player.step * DT, player.drive.end * DT, playing)
