"""What sensors read, less what the machine would let them read: residuals (`channels_of`) of blocks of a log.

A spool without a sensor is that of its pilot, a flow without one that of the circuit.
"""

from collections.abc import Callable, Hashable, Mapping
from typing import Any, NamedTuple

import numpy as np

from polydraulic.flow.layout.circuit_sample import solved_valves
from polydraulic.machine.frames import link_frames
from polydraulic.machine.newton_euler import axis_of, needed_wrenches
from polydraulic.machine.pump import limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.machine.volumes import levers, side_volumes
from polydraulic.parameters.layout.parts import MachineFunction, SupplyCircuit
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.watch.blocks import MOTION_STRIDE, SMOOTH, BlockShape, filtered, motion_filters, smoothing
from polydraulic.watch.channels import WatchChannel, position_of

# rad or m, or a smaller share of the way, within which a joint may be at its stop whatever its sensor is off
_NEAR_STOP = 0.1
# Pa within which a make-up valve, or a relief valve, may be open, whatever a sensor is off
_FROM_FLOOR, _FROM_RELIEF = 15e5, 10e5
_RELIEF_BAND = 5e5  # Pa on either side of its setting in which a line's relief valve may be open
_LEAST_LOSS = 5e-5  # m3/s
_FLOWS = 0.03  # of the pump's flow
_LEAST_OUTLET = 0.02  # of the widest conductance
_STILL = 0.1  # of friction, which nobody knows better

Readings = Mapping[str, np.ndarray]  # by column, (n_block, n_row) in SI
Shifts = Mapping[str, float]  # what sensors read too much, by column


class Case(NamedTuple):
    """A machine as it may be: its numbers, what hangs at its tip, kg, and what its sensors read too much.

    `mechanics` is a text that tells machines with other links or pins apart.
    """

    machine: LayoutMachine
    payload: float
    shifts: Shifts
    mechanics: str


def case_of(machine: LayoutMachine, payload: float = 0.0, shifts: Shifts | None = None) -> Case:
    """A machine as it may be."""
    return Case(machine, payload, shifts or {}, repr((machine.links, [f.pins for f in machine.functions])))


class Residuals:
    """Residuals of some blocks, of one machine after the other: what two of them share is computed once.

    Parameters
    ----------
    readings : Readings
    shape : BlockShape
    channels : tuple of WatchChannel
        From `channels_of`.
    """

    def __init__(self, readings: Readings, shape: BlockShape, channels: tuple[WatchChannel, ...]) -> None:
        self.readings, self.shape, self.channels = readings, shape, channels
        self._known: dict[Hashable, Any] = {}

    def of(self, case: Case) -> list[np.ndarray]:
        """Residual of each channel, (n_block, n_instant): the same array wherever nothing that it depends on is another."""
        return [self._once(*self._recipe(channel, case)) for channel in self.channels]

    def counts(self, case: Case) -> list[np.ndarray]:
        """Where each residual is worth something, (n_block, n_instant) of bool."""
        return [self._counts(channel, case) for channel in self.channels]

    def friction_unsure(self, channel: WatchChannel, case: Case) -> np.ndarray:
        """What nobody knows of a joint's friction at each instant, (n_block, n_instant) in N m: at rest anything up to static friction."""
        name = channel.name.partition(".")[0]
        _, rates, _ = self._motion(case)
        f = case.machine.function(name).friction
        w = rates[..., case.machine.names.index(name)]
        held = f.static / np.sqrt(3.0) * (1.0 - np.tanh(w / f.smoothing) ** 2)
        return np.hypot(_STILL * np.abs(_friction(case.machine.function(name), w)), held)

    def lever(self, name: str, case: Case) -> np.ndarray:
        """Larger lever of a function's actuator as windows begin, (n_block, n_window) in m3 per rad or m."""
        a, b = self._volumes(name, case)[2:]
        return np.asarray(np.maximum(a, b)[:, self._window_starts()])

    # -------------------------------------------------------------------------------------------------------------- stages

    def _once(self, key: Hashable, make: Callable[[], Any]) -> Any:
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]

    def _read(self, column: str, case: Case) -> np.ndarray:
        shift = case.shifts.get(column, 0.0)
        return self.readings[column] - shift if shift else self.readings[column]

    def _key(self, case: Case, *columns: str) -> tuple[float, ...]:
        return tuple(case.shifts.get(column, 0.0) for column in columns)

    def _recipe(self, channel: WatchChannel, case: Case) -> tuple[Hashable, Callable[[], np.ndarray]]:
        name, _, what = channel.name.partition(".")
        f, judged = case.machine.function(name), self.shape.judged
        key: Hashable
        if what == "spool":
            key = (
                f.pilot,
                f.valve.knots[-1],
                f.effects.hysteresis,
                self._key(case, f"{name}.voltage", f"{name}.spool"),
            )
            return (channel, key), lambda: (self._read(f"{name}.spool", case) - self._driven(name, case))[:, judged]
        if what == "q_in":
            predicted = self._flow_in(name, case)
            key = (id(predicted), self._key(case, f"{name}.{what}"))
            return (channel, key), lambda: (self._read(f"{name}.{what}", case) - predicted)[:, judged]
        if what == "p_out":
            k, out, rest = self._outlet(name, case), self._ports(name, case)[1], case.machine.tank.return_pressure
            key = (id(k), id(out), rest, self._key(case, f"{name}.q_out"))
            return (channel, key), lambda: self._outlet_pressure(name, case, k, out - rest)[:, judged]
        if what == "torque":
            parts = self._torque(name, case)
            return (channel, tuple(map(id, parts))), lambda: parts[0] - parts[1] - parts[2]
        sides = self._line(name, case)
        side = sides[0] if what == "volume_a" else sides[1]
        return (channel, id(side)), lambda: side

    def _driven(self, name: str, case: Case) -> np.ndarray:
        f = case.machine.function(name)
        columns = (f"{name}.voltage", f"{name}.spool")
        key = ("driven", name, f.pilot, f.valve.knots[-1], f.effects.hysteresis, self._key(case, *columns))
        return self._once(key, lambda: self._drive(f, case))

    def _drive(self, f: MachineFunction, case: Case) -> np.ndarray:
        """Spool that the voltage alone drives from where it is at first, the voltage straight between rows."""
        voltage, step = self._read(f"{f.name}.voltage", case), self.shape.raster
        late = f.pilot.dead_time / step
        rows = np.arange(voltage.shape[1])
        lower = np.clip(np.floor(rows - late), 0, len(rows) - 1).astype(np.int64)
        share = np.clip(rows - late - lower, 0.0, 1.0)
        seen = voltage[:, lower] * (1.0 - share) + voltage[:, np.minimum(lower + 1, len(rows) - 1)] * share
        target = np.clip(f.pilot.gain * seen, -f.valve.knots[-1], f.valve.knots[-1])
        keep = float(np.exp(-step / f.pilot.time_constant))
        second = 1.0 - (1.0 - keep) * f.pilot.time_constant / step
        first = 1.0 - keep - second
        found = np.empty_like(target)
        x = (
            self._read(f"{f.name}.spool", case)[:, :3].mean(axis=1)
            if f"{f.name}.spool" in self.readings
            else target[:, 0]
        )
        found[:, 0] = x
        for k in range(1, target.shape[1]):
            x = keep * x + first * target[:, k - 1] + second * target[:, k]
            found[:, k] = x
        return found if not f.effects.hysteresis else _followed(found, 0.5 * f.effects.hysteresis)

    def _spool(self, name: str, case: Case) -> np.ndarray:
        column = f"{name}.spool"
        if column not in self.readings:
            return self._driven(name, case)
        return self._once(
            ("spool", column, self._key(case, column)), lambda: filtered(self._read(column, case), smoothing(SMOOTH))
        )

    def _pressure(self, column: str, case: Case) -> np.ndarray:
        return self._once(
            ("pressure", column, self._key(case, column)), lambda: np.maximum(self._read(column, case), 0.0)
        )

    def _ports(self, name: str, case: Case) -> tuple[np.ndarray, np.ndarray]:
        """Pressures at the pressurised port and at the outlet."""
        x, a, b = self._spool(name, case), self._pressure(f"{name}.p_a", case), self._pressure(f"{name}.p_b", case)
        return self._once(("ports", id(x), id(a), id(b)), lambda: (np.where(x >= 0.0, a, b), np.where(x >= 0.0, b, a)))

    def _flow_in(self, name: str, case: Case) -> np.ndarray:
        c = next(c for c in case.machine.circuits if name in c.functions)
        ports = [self._ports(f, case)[0] for f in c.functions]
        spools = [self._spool(f, case) for f in c.functions]
        curves = tuple((v.knots, v.inlet, v.bypass) for v in (case.machine.function(f).valve for f in c.functions))
        key = ("circuit", c.name, c.pump, curves, case.machine.tank, *map(id, ports), *map(id, spools))
        return self._once(key, lambda: self._solve(c, case, spools, ports))[c.functions.index(name)]

    def _solve(
        self, c: SupplyCircuit, case: Case, spools: list[np.ndarray], ports: list[np.ndarray]
    ) -> list[np.ndarray]:
        pump = limited_pump(c.pump.flow, c.pump.relief, case.machine.tank.return_pressure, c.pump)
        valves = [case.machine.function(f).valve for f in c.functions]
        travel = np.column_stack(
            [np.minimum(np.abs(x), v.knots[-1]).ravel() for x, v in zip(spools, valves, strict=True)]
        )
        sample, proved = solved_valves(valves, pump, travel, np.column_stack([p.ravel() for p in ports]))
        flows = np.where(proved[:, None], sample.q_in, np.nan)
        return [np.ascontiguousarray(flows[:, k]).reshape(spools[0].shape) for k in range(len(valves))]

    def _outlet(self, name: str, case: Case) -> np.ndarray:
        """Conductance of the outlet."""
        valve, x = case.machine.function(name).valve, self._spool(name, case)
        curves = (valve.knots, valve.outlet_positive, valve.outlet_negative)

        def made() -> np.ndarray:
            sides = [np.interp(np.abs(x), valve.knots, curve) for curve in curves[1:]]
            return np.where(x >= 0.0, *sides)

        return self._once(("outlet", name, curves, id(x)), made)

    def _outlet_pressure(self, name: str, case: Case, k: np.ndarray, above: np.ndarray) -> np.ndarray:
        """Pressure above the return line, less that which the measured flow needs; nan where the outlet is hardly open."""
        valve = case.machine.function(name).valve
        least = _LEAST_OUTLET * max(*valve.outlet_positive, *valve.outlet_negative)
        flow = np.maximum(self._read(f"{name}.q_out", case), 0.0)
        return np.where(k > least, above - (flow / np.maximum(k, least)) ** 2, np.nan)

    def _flow_out(self, name: str, case: Case) -> np.ndarray:
        k, out, rest = self._outlet(name, case), self._ports(name, case)[1], case.machine.tank.return_pressure
        return self._once(("out", id(k), id(out), rest), lambda: k * np.sqrt(np.maximum(out - rest, 0.0)))

    def _volumes(self, name: str, case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Volumes of both sides, and both levers."""
        f = case.machine.function(name)
        column = position_of(case.machine, f)

        def made() -> tuple[np.ndarray, ...]:
            position = filtered(self._read(column, case), smoothing(SMOOTH))
            return (*side_volumes(case.machine, f, position), *levers(case.machine, f, position))

        return self._once(("volumes", name, f.drive, case.mechanics, self._key(case, column)), made)

    def _line(self, name: str, case: Case) -> tuple[np.ndarray, np.ndarray]:
        f = case.machine.function(name)
        x, volumes = self._spool(name, case), self._volumes(name, case)
        a, b = self._pressure(f"{name}.p_a", case), self._pressure(f"{name}.p_b", case)
        into = self._read(f"{name}.q_in", case) if f"{name}.q_in" in self.readings else self._flow_in(name, case)
        out = self._read(f"{name}.q_out", case) if f"{name}.q_out" in self.readings else self._flow_out(name, case)
        read = self._key(case, f"{name}.q_in", f"{name}.q_out")
        into_id = read[0] if f"{name}.q_in" in self.readings else id(into)
        out_id = read[1] if f"{name}.q_out" in self.readings else id(out)
        line = f.line
        key = ("line", name, line, id(x), id(volumes), id(a), id(b), into_id, out_id)

        def made() -> tuple[np.ndarray, np.ndarray]:
            seconds = self.shape.window * self.shape.raster
            ahead = x >= 0.0
            leak = line.leakage * (a - b)
            found = []
            for volume, p, compliance, through in (
                (volumes[0], a, line.compliance_a, np.where(ahead, into, -out) - leak - line.external_leakage * a),
                (volumes[1], b, line.compliance_b, np.where(ahead, -out, into) + leak - line.external_leakage * b),
            ):
                moved, passing = self._ends(volume) / seconds, self._means(through)
                pressed = compliance * self._ends(p) / seconds
                most = self._most(filtered(p, smoothing(SMOOTH)))
                lost = np.where(
                    np.abs(most - line.relief) < _RELIEF_BAND,
                    np.maximum(passing - moved - _LEAST_LOSS, 0.0),  # as much as does not go elsewhere
                    np.where(most < line.relief, 0.0, self._means(np.maximum(through, 0.0)) + np.maximum(-moved, 0.0)),
                )
                found.append(moved + pressed - passing + lost)
            return found[0], found[1]

        return self._once(key, made)

    def _window_starts(self) -> np.ndarray:
        s = self.shape
        return s.before + s.window * np.arange(s.inside // s.window)

    def _ends(self, values: np.ndarray) -> np.ndarray:
        starts = self._window_starts()
        return np.asarray(values[:, starts + self.shape.window] - values[:, starts])

    def _means(self, values: np.ndarray) -> np.ndarray:
        """Means over windows, by straight lines between rows, (n_block, n_window)."""
        starts, long = self._window_starts(), self.shape.window
        gathered = values[:, starts[:, None] + np.arange(long + 1)]
        return np.asarray((gathered.sum(axis=-1) - 0.5 * (gathered[..., 0] + gathered[..., -1])) / long)

    def _most(self, values: np.ndarray) -> np.ndarray:
        """Largest value in windows."""
        return np.asarray(values[:, self._window_starts()[:, None] + np.arange(self.shape.window + 1)].max(axis=-1))

    def _instants(self) -> np.ndarray:
        stride = max(1, round(MOTION_STRIDE / self.shape.raster))
        return np.arange(self.shape.before, self.shape.before + self.shape.inside, stride)

    def _at_instants(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        half = len(weights) // 2
        return np.asarray(values[:, self._instants()[:, None] + np.arange(-half, half + 1)] @ weights)

    def _motion(self, case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, rates and accelerations at instants, (n_block, n_instant, n_function) each."""
        columns = [position_of(case.machine, f) for f in case.machine.functions]

        def made() -> tuple[np.ndarray, ...]:
            filters = motion_filters(self.shape.raster)
            return tuple(
                np.stack([self._at_instants(self._read(column, case), weights) for column in columns], axis=-1)
                for weights in filters
            )

        return self._once(("motion", self._key(case, *columns)), made)

    def _torque(self, name: str, case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Torque of the oil, friction, and torque that the motion needs, (n_block, n_instant) each."""
        f, place = case.machine.function(name), case.machine.names.index(name)
        motion = self._motion(case)
        a, b = self._pressure(f"{name}.p_a", case), self._pressure(f"{name}.p_b", case)
        volumes = self._volumes(name, case)
        smooth = motion_filters(self.shape.raster)[0]
        oil = self._once(
            ("oil", name, id(a), id(b), id(volumes)),
            lambda: self._at_instants(volumes[2] * a - volumes[3] * b, smooth),
        )
        friction = self._once(("friction", name, f.friction, id(motion)), lambda: _friction(f, motion[1][..., place]))
        needed = self._once(
            ("needed", case.mechanics, case.machine.gravity, case.payload, id(motion)), lambda: _needed(case, *motion)
        )
        return oil, friction, needed[place]

    # --------------------------------------------------------------------------------------------------------------- masks

    def _counts(self, channel: WatchChannel, case: Case) -> np.ndarray:
        name, _, what = channel.name.partition(".")
        f = case.machine.function(name)
        if what == "torque":
            q = self._read(position_of(case.machine, f), case)
            near = min(_NEAR_STOP, 0.06 * (f.stops.high - f.stops.low))
            away = (q > f.stops.low + near) & (q < f.stops.high - near)
            half = len(motion_filters(self.shape.raster)[0]) // 2
            return np.asarray(away[:, self._instants()[:, None] + np.arange(-half, half + 1)].all(axis=-1))
        if what in ("volume_a", "volume_b"):
            p = filtered(self._read(f"{name}.p_{what[-1]}", case), smoothing(SMOOTH))
            fine = (p > case.machine.tank.floor + _FROM_FLOOR) & (p < f.line.relief - _FROM_RELIEF)
            return np.asarray(fine[:, self._window_starts()[:, None] + np.arange(self.shape.window + 1)].all(axis=-1))
        if what == "p_out":  # where nothing flows, the line may be empty
            out = filtered(self._read(f"{name}.q_out", case), smoothing(SMOOTH))
            pump = next(c.pump for c in case.machine.circuits if name in c.functions)
            return np.asarray(out[:, self.shape.judged] > _FLOWS * pump.flow)
        judged = np.ones((len(next(iter(self.readings.values()))), self.shape.inside), dtype=bool)
        return judged & ~self._near_relief(name, case)[:, self.shape.judged] if what == "q_in" else judged

    def _near_relief(self, name: str, case: Case) -> np.ndarray:
        """Where a valve of the circuit feeds a port near the relief setting: flows fall there from all to nothing within what a sensor tells."""
        c = next(c for c in case.machine.circuits if name in c.functions)
        return np.any(
            [
                (self._ports(f, case)[0] > c.pump.relief - _FROM_RELIEF)
                & (np.abs(self._spool(f, case)) > spool_edges(case.machine.function(f).valve)[0])
                for f in c.functions
            ],
            axis=0,
        )


def _followed(driven: np.ndarray, half: float) -> np.ndarray:
    """Spool that follows what drives it with play, (n_block, n_row); where it begins it is in the middle."""
    found = driven.copy()
    for k in range(1, driven.shape[1]):
        found[:, k] = np.clip(found[:, k - 1], driven[:, k] - half, driven[:, k] + half)
    return found


def _friction(f: MachineFunction, rate: np.ndarray) -> np.ndarray:
    of = f.friction
    level = of.coulomb + (of.static - of.coulomb) * np.exp(-((rate / of.stribeck) ** 2))
    return np.asarray(level * np.tanh(rate / of.smoothing) + of.viscous * rate)


def _needed(case: Case, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> list[np.ndarray]:
    """Torque that a motion needs of each function, (n_block, n_instant) each."""
    machine = with_payload(case.machine, case.payload) if case.payload else case.machine
    flat = [values.reshape(-1, values.shape[-1]) for values in (q, qd, qdd)]
    frames = link_frames(machine, flat[0])
    wrenches = needed_wrenches(machine, frames, flat[1], flat[2], np.zeros((len(flat[0]), 3)))
    found = []
    for f in machine.functions:
        link, wrench = machine.link(f.moves), wrenches[f.name]
        carried = wrench.moment if link.joint == "revolute" else wrench.force
        found.append((carried * axis_of(link, frames)).sum(axis=1).reshape(q.shape[:-1]))
    return found
