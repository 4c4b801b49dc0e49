"""`CoordinatedControl`: levers say how the tip is to move, and all functions of the machine move together for it."""

from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.control.arm import planar_arm, pump_rate
from polydraulic.control.servo import Servo
from polydraulic.control.text import INVERTED, controller_module, live_places
from polydraulic.errors import InputError, briefly
from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.flow.lookup import table_bytes
from polydraulic.machine.stability.body import Body
from polydraulic.machine.stability.whole_body import body_of
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine, position_columns
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.layout.prepare import prepare_layout, valves_of
from polydraulic.simulation.stepping.packed import pack_tree
from polydraulic.simulation.steps import check_time_step

VELOCITIES = ("reach", "height", "swing", "pitch")


class ControlSettings(NamedTuple):
    """How a controller moves a machine.

    Attributes
    ----------
    dt : float, s
        Between two calls.
    delay : float, s
        By which measurements are older than the call that gets them.
    reach, height : float, m/s
        Speed of the tip at full lever.
    swing, pitch : float, rad/s
        Of swing and attachment at full lever.
    gain : float, 1/s
        Of the joint servos: speed per error.
    integral_gain : float, 1/s2
    acceleration : float, m/s2
        Of the tip; swing and attachment accelerate with as many rad/s2.
    settling : float, s
        Time constant with which spools go where they should; shorter than their pilots', at the price of larger voltages.
    load_time : float, s
        Over which measured pressures are smoothed.
    margin : float
        Share of each joint's range that is kept free at both stops.
    shares_flow : bool
        Whether all motion is slowed when a pump cannot give what it asks for; without, each function takes what it gets.
    tip_margin : float, m
        How far the machine stays from tipping, by the dynamic distance that is foreseen for a stop (`polydraulic.StabilityMonitor`): all motion is slowed
        ahead of it, and refused where it would come nearer. 0 looks after nothing; above that the machine needs a chassis.
    payload : float, kg
        What hangs at the tip as far as `tip_margin` knows.
    """

    dt: float = 0.01
    delay: float = 0.0
    reach: float = 0.6
    height: float = 0.6
    swing: float = 0.4
    pitch: float = 0.6
    gain: float = 3.0
    integral_gain: float = 1.5
    acceleration: float = 0.8
    settling: float = 0.06
    load_time: float = 0.5
    margin: float = 0.01
    shares_flow: bool = True
    tip_margin: float = 0.0
    payload: float = 0.0


USUAL = ControlSettings()
_HALT = 0.2  # s that a valve's closing takes anyway
_MAY_BE_ZERO = ("delay", "integral_gain", "margin", "load_time", "shares_flow", "tip_margin", "payload")


class ControlParts(NamedTuple):
    """A controller as an exporter wants it.

    Attributes
    ----------
    numbers : named tuple, called Controller
        All numbers that a call reads.
    step : kernel (numbers, scratch, live, measured, wanted, volts) -> int
    n_live, n_scratch : int
        Lengths of the arrays that a call changes; zeros at the start.
    share : int
        Place in `live` of the share of the wanted velocity.
    n_number : int
        Numbers in tables of networks.
    """

    numbers: Any
    step: Callable[..., int]
    n_live: int
    n_scratch: int
    share: int
    n_number: int


class CoordinatedControl:
    """A controller that moves the tip of a machine: reach, height, swing, and the attachment's angle, which is held otherwise.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        As the controller knows it: drawn, or identified from a log.
    flow : str or flow model
        Whose circuits are inverted: ``"exact"``, or networks.
    settings : ControlSettings

    Attributes
    ----------
    names : tuple of str
        Functions, in the order of the voltages.
    reference : (4,) array
        Where the tip should be: reach and height in m, swing and pitch in rad; follows every call.
    joints : (n_function,) array
        Where the joints should be.
    share : () array
        Share of the wanted velocity that flow, limits and the margin against tipping allow.
    tip_share : () array
        What of it the margin against tipping alone allows: below 1 the motion is slowed, 0 is refused. 1 without a margin.
    dt : float, s
    parts : ControlParts
        For exporters.
    lag : float, s
        By which the machine follows its reference, besides the delay.

    Raises
    ------
    InputError
        A machine without a planar arm, a flow model that is neither exact nor made of networks, settings that cannot be used; a machine
        without a chassis that is to be kept from tipping.

    Examples
    --------
    >>> from polydraulic import Simulator
    >>> control = CoordinatedControl("cat215b")
    >>> with Simulator("cat215b") as machine:
    ...     before = float(machine["effector.x"]), float(machine["effector.z"])
    ...     for _ in range(200):
    ...         machine.step(control.step(control.measured(machine), {"reach": 0.3}), n=2)
    ...     x, z = float(machine["effector.x"]) - before[0], float(machine["effector.z"]) - before[1]
    >>> x > 0.3 and abs(z) < 0.1
    True
    """

    def __init__(
        self,
        machine: LayoutMachine | str | Path,
        flow: str | FlowModel = "exact",
        *,
        settings: ControlSettings = USUAL,
    ) -> None:
        self.machine = as_machine(machine)
        self.names = self.machine.names
        self.settings = _checked(settings)
        model = layout_flow(flow, self.machine)
        if model.kernels not in INVERTED:
            raise InputError(
                f"flow {model.name!r}: valves are inverted of 'exact' circuits and of networks; use one of these"
            )
        unserved = [name for name in self.names if name not in model.served]
        if unserved:
            raise InputError(
                f"flow {model.name!r} has no networks for {', '.join(unserved)}; train networks of their circuits, too"
            )
        ready = prepare_layout(self.machine, settings.dt, flow=model)
        self.arm = planar_arm(self.machine)
        self.servo = servo_of(self.machine, settings)
        parts: dict[str, Any] = {"valves": ready.valves, "plant": ready.plant, "servo": self.servo, "arm": self.arm}
        if settings.tip_margin > 0.0:
            parts["body"] = self._body()
        self._module = controller_module(self.machine, ready.module, parts, model.kernels)
        self._tree = parts
        self._numbers, self._whole = pack_tree(tuple(parts.values()))
        self._valves = ready.valves  # which keep the machine code of networks
        exported = parts | {"valves": valves_of(self.machine, ready.module, model, in_tables=True)}
        n, places = len(self.names), live_places(self.machine, guarded="body" in parts)
        self._live = np.zeros(places["RING"] + n * (self.servo.ring + 1))
        self._scratch = np.zeros(max(ready.n_memory, 1))
        self.parts = ControlParts(
            self._module.Controller(*exported.values()), self._module.control_step, len(self._live), len(self._scratch), places["SHARE"],
            table_bytes(model.parts) // 8,
        )  # fmt: skip
        self._measured, self._wanted, self._volts = np.zeros(3 * n), np.zeros(4), np.zeros(n)
        seen = self._live.view()
        seen.flags.writeable = False
        self.reference = seen[places["POSE"] : places["POSE"] + 4]
        self.joints = seen[places["REFERENCE"] : places["REFERENCE"] + n]
        self.share = seen[places["SHARE"] : places["SHARE"] + 1].reshape(())
        self.tip_share = seen[places["KEPT"] :][:1].reshape(()) if "body" in parts else np.array(1.0)
        self.dt = settings.dt
        self.lag = settings.settling + max(f.pilot.dead_time for f in self.machine.functions)

    def reset(self) -> None:
        """Forget everything: the next call begins where the machine is then."""
        self._live[:] = 0.0

    def carry(self, payload: float) -> None:
        """Know of another payload from the next call on, as `settings.payload` says it at the beginning.

        Parameters
        ----------
        payload : float, kg
            What hangs at the tip.

        Raises
        ------
        InputError
            What is no mass; nothing has changed.
        """
        self.settings = _checked(self.settings._replace(payload=payload))
        if "body" in self._tree:
            self._tree["body"] = self._body()
            self._numbers, self._whole = pack_tree(tuple(self._tree.values()))
            self.parts = self.parts._replace(numbers=self.parts.numbers._replace(body=self._tree["body"]))

    def measured(self, outputs: Mapping[str, Any] | Any) -> np.ndarray:
        """What a call wants to know of a machine, from outputs by name: those of a `Simulator`, or a mapping.

        Returns
        -------
        (3 n_function,) array
            Positions of the joints in rad or m, pressures at A, then at B, in Pa.
        """
        for place, column in enumerate(measured_columns(self.machine)):
            self._measured[place] = outputs[column]
        return self._measured

    def step(self, measured: np.ndarray, wanted: np.ndarray | Mapping[str, float]) -> np.ndarray:
        """One call, to be made every `settings.dt` seconds.

        Parameters
        ----------
        measured : (3 n_function,) array
            As `measured` gives it.
        wanted : (4,) array, or mapping from one of ``reach``, ``height`` (m/s), ``swing``, ``pitch`` (rad/s) to a velocity
            Of the tip; pitch is that of the attachment to the ground. With all of them zero the valves close, whatever the errors are.

        Returns
        -------
        (n_function,) array, V
            Of the levers. It is the controller's own, and changes with the next call.

        Raises
        ------
        InputError
            Velocities that there are not, or values that are no numbers; nothing has changed.
        """
        if isinstance(wanted, Mapping):
            wanted = _velocity(wanted)
        if not (_fits(measured, self._measured.shape) and _fits(wanted, self._wanted.shape)):
            raise InputError(
                f"measured must be {len(self._measured)} finite numbers (positions, then pressures at A and B, of {', '.join(self.names)}) and "
                f"wanted {len(VELOCITIES)} ({', '.join(VELOCITIES)})"
            )
        self._module.control(self._numbers, self._whole, self._scratch, self._live, measured, wanted, self._volts)
        return self._volts

    def velocity(self, sticks: np.ndarray) -> np.ndarray:
        """Velocity of the tip that sticks ask for: left stick swing and reach, right stick attachment and height.

        Parameters
        ----------
        sticks : (6,) array
            From -1 to 1, in the order of `polydraulic.control.lever_patterns.STICKS`; forward is out, and down.
        """
        s = self.settings
        return np.array([sticks[1] * s.reach, -sticks[3] * s.height, -sticks[0] * s.swing, sticks[2] * s.pitch])

    def _body(self) -> Body:
        """The machine, and what hangs at its tip, as one body on the ground."""
        payload = self.settings.payload
        return body_of(with_payload(self.machine, payload) if payload else self.machine)


def measured_columns(machine: LayoutMachine) -> list[str]:
    """Columns that a controller gets: positions, pressures at A, then at B, of all functions."""
    return [*position_columns(machine), *(f"{name}.{side}" for side in ("p_a", "p_b") for name in machine.names)]


def servo_of(machine: LayoutMachine, settings: ControlSettings) -> Servo:
    """Numbers of a controller of a machine."""
    functions = machine.functions
    circuit = {name: number for number, c in enumerate(machine.circuits) for name in c.functions}
    flows = np.array([machine.circuits[circuit[f.name]].pump.flow for f in functions])
    speed = np.array([pump_rate(machine, f) for f in functions])
    stops = np.array([f.stops for f in functions])
    kept = settings.margin * (stops[:, 1] - stops[:, 0])
    knots = [np.array(f.valve.knots) for f in functions]
    opens = np.array(
        [k[max(np.flatnonzero(np.array(f.valve.inlet) > 0.0)[0] - 1, 0)] for f, k in zip(functions, knots, strict=True)]
    )
    time = np.array([f.pilot.time_constant for f in functions])
    order = [machine.names.index(name) for c in machine.circuits for name in c.functions]
    decay = np.exp(-settings.dt / time)
    lead = np.maximum((1.0 - np.exp(-settings.dt / settings.settling)) / (1.0 - decay), 1.0)
    dead = max(f.pilot.dead_time for f in functions)
    return Servo(
        dt=settings.dt,
        gain=settings.gain,
        integral_gain=settings.integral_gain,
        most_integral=0.2,
        acceleration=settings.acceleration,
        turning=settings.acceleration,
        slow=0.15,
        blend=settings.dt / (settings.load_time + settings.dt),
        lead=lead,
        low=stops[:, 0] + kept,
        high=stops[:, 1] - kept,
        braking=0.5 * speed / 0.5,
        band=0.004 * np.ones(len(functions)),
        patience=0.02 * np.ones(len(functions)),
        small=0.004 * flows,
        speed=speed,
        opens=opens,
        travel=np.array([k[-1] for k in knots]),
        pilot_gain=np.array([f.pilot.gain for f in functions]),
        decay=decay,
        circuit=np.array([circuit[f.name] for f in functions], dtype=np.int64),
        order=np.array(order, dtype=np.int64),
        ring=round((settings.delay + settings.settling + dead) / settings.dt),
        shares=int(settings.shares_flow),
        floor=machine.tank.floor,
        p_return=machine.tank.return_pressure,
        tip_margin=settings.tip_margin,
        halt=_HALT + settings.settling,
        late=settings.settling + dead,
    )


def _checked(settings: ControlSettings) -> ControlSettings:
    check_time_step(settings.dt)
    for name, value in settings._asdict().items():
        zero = name in _MAY_BE_ZERO
        if not (isinstance(value, int | float) and isfinite(value) and (value >= 0.0 if zero else value >= 1e-6)):
            allowed = "a number, 0 or more" if zero else "a number above 0"
            raise InputError(f"settings: {name} = {briefly(value)}: must be {allowed}")
    if settings.margin >= 0.5:
        raise InputError(f"settings: margin = {settings.margin:g}: must be below 0.5, a half of each joint's range")
    if settings.delay > 1.0:
        raise InputError(f"settings: delay = {settings.delay:g} s: at most 1 s")
    return settings


def _velocity(wanted: Mapping[str, float]) -> np.ndarray:
    unknown = [name for name in wanted if name not in VELOCITIES]
    if unknown:
        raise InputError(f"wanted names {briefly(unknown[0])}; a velocity has {list(VELOCITIES)}")
    try:
        return np.array([float(wanted.get(name, 0.0)) for name in VELOCITIES])
    except (TypeError, ValueError) as error:
        raise InputError(f"wanted = {briefly(dict(wanted))}: must be numbers, in m/s and rad/s") from error


def _fits(values: Any, shape: tuple[int, ...]) -> bool:
    return (
        isinstance(values, np.ndarray)
        and values.dtype == np.float64
        and values.shape == shape
        and bool(np.isfinite(values).all())
    )
