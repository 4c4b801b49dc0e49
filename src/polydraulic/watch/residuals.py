"""What sensors read, less what the machine would let them read: residuals (`channels_of`) of a block, as steps of a plan.

A spool without a sensor is that of its pilot, a flow without one that of the circuit. Places are those in a plan's room.
"""

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.machine.frames import AXES, vector
from polydraulic.machine.newton_euler import tensor_of
from polydraulic.machine.pump import limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.machine.volumes import lever_grid, levers, side_volumes
from polydraulic.parameters.layout.parts import SlideFriction
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.parameters.schema import Friction
from polydraulic.watch.blocks import MOTION_STRIDE, SMOOTH, BlockShape, motion_filters, smoothing
from polydraulic.watch.channels import WatchChannel, circuits_beside, crossover_of, valves_beside
from polydraulic.watch.kernels.motion import ROOM_OF_LINK
from polydraulic.watch.kernels.numbers import HEAD_OF_LIVE
from polydraulic.watch.plan import Plan

# rad or m, or a smaller share of the way, within which a joint may be at its stop whatever its sensor is off
_NEAR_STOP = 0.1
# Pa within which a make-up valve, or a relief valve, may be open, whatever a sensor is off
_FROM_FLOOR, _FROM_RELIEF = 15e5, 10e5
_RELIEF_BAND = 5e5  # Pa on either side of its setting in which a line's relief valve may be open
_LEAST_LOSS = 5e-5  # m3/s
_FLOWS = 0.03  # of the pump's flow
_LEAST_OUTLET = 0.02  # of the widest conductance
_STILL = 0.1  # of friction, which nobody knows better

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
    """Residuals of one machine after the other as steps of a plan: what two of them share is one step.

    Parameters
    ----------
    columns : sequence of str
        That rows hold, behind the time.
    shape : BlockShape
    channels : tuple of WatchChannel
        From `channels_of`.
    """

    def __init__(self, columns: Sequence[str], shape: BlockShape, channels: tuple[WatchChannel, ...]) -> None:
        self.columns, self.shape, self.channels, self.plan = tuple(columns), shape, channels, Plan()
        self.filters = motion_filters(shape.raster)
        self.half = len(self.filters[0]) // 2
        self.stride = max(1, round(MOTION_STRIDE / shape.raster))
        self.instants = len(range(shape.before, shape.before + shape.inside, self.stride))
        self.windows = shape.inside // shape.window

    def of(self, case: Case) -> list[int]:
        """Where the residual of each channel begins: the same place wherever nothing that it depends on is another."""
        return [self.plan.once(*self._recipe(channel, case)) for channel in self.channels]

    def length(self, channel: WatchChannel) -> int:
        """How many residuals a channel has in a block."""
        what = channel.name.rpartition(".")[2]
        return self.instants if what == "torque" else self.windows if what.startswith("volume") else self.shape.inside

    def counts(self, channel: WatchChannel, case: Case) -> int:
        """Where it stands whether each residual is worth something: 1 if so."""
        name, _, what = channel.name.partition(".")
        plan, shape = self.plan, self.shape
        if what == "torque":
            f = case.machine.function(name)
            near = min(_NEAR_STOP, 0.06 * (f.stops.high - f.stops.low))
            q = self._read(position_column(case.machine, f), case)
            numbers = plan.numbers((f.stops.low + near, f.stops.high - near))
            return plan.filled(
                self.instants, "within", q, shape.before - self.half, 2 * self.half, self.stride, numbers
            )
        if what in ("volume_a", "volume_b"):
            p = self._smooth(self._read(f"{name}.p_{what[-1]}", case))
            relief = case.machine.function(name).line.relief
            numbers = plan.numbers((case.machine.tank.floor + _FROM_FLOOR, relief - _FROM_RELIEF))
            return plan.filled(self.windows, "within", p, shape.before, shape.window, shape.window, numbers)
        if what == "p_out":  # where nothing flows, the line may be empty
            out = self._smooth(self._read(f"{name}.q_out", case))
            pump = next(c.pump for c in case.machine.circuits if name in c.functions)
            return plan.filled(shape.inside, "above", out, shape.before, plan.numbers((_FLOWS * pump.flow,)))
        # where a valve of the circuit feeds a port near the relief setting, flows fall from all to nothing within what a sensor tells
        functions = valves_beside(case.machine, name) if what == "q_in" else ()
        edges = [spool_edges(case.machine.function(g).valve)[0] for g in functions]
        valves = [place for g in functions for place in (self._ports(g, case)[0], self._spool(g, case))]
        limit = min(c.pump.relief for c in circuits_beside(case.machine, name)) - _FROM_RELIEF if functions else 0.0
        numbers = plan.numbers((limit, *edges))
        return plan.filled(shape.inside, "clear_of_relief", shape.before, numbers, len(functions), *valves)

    def add_friction_unsure(self, variance: int, channel: WatchChannel, case: Case) -> None:
        """Add to a variance what nobody knows of a joint's friction at each instant: at rest anything up to static friction."""
        name = channel.name.partition(".")[0]
        rate = self._motion(case)[case.machine.names.index(name)][1]
        f = case.machine.function(name).friction
        numbers = (*_friction_numbers(f), _STILL, f.static / np.sqrt(3.0))
        self.plan.step("add_friction_unsure", variance, self.instants, rate, self.plan.numbers(numbers))

    def add_window_noise(self, variance: int, name: str, case: Case, position: float, rest: float) -> None:
        """Add to a variance the noise of a balance: of the position at both ends, rad or m, and the rest, (m3/s)^2."""
        lever_a = self._volumes(name, case) + 2 * self.shape.rows
        seconds = self.shape.window * self.shape.raster
        numbers = self.plan.numbers((np.sqrt(2.0) * position / seconds, rest))
        lever_b = lever_a + self.shape.rows
        shape = self.shape
        self.plan.step(
            "add_window_noise", variance, self.windows, lever_a, lever_b, shape.before, shape.window, numbers
        )

    # -------------------------------------------------------------------------------------------------------------- stages

    def _read(self, column: str, case: Case) -> int:
        shift = case.shifts.get(column, 0.0)

        def made() -> int:
            place, numbers = HEAD_OF_LIVE + 1 + self.columns.index(column), self.plan.numbers((shift,))
            return self._rows("read", place, 1 + len(self.columns), numbers)

        return self.plan.once(("read", column, shift), made)

    def _rows(self, name: str, *places: int) -> int:
        return self.plan.filled(self.shape.rows, name, *places)

    def _smooth(self, of: int) -> int:
        weights = self.plan.numbers(smoothing(SMOOTH).tolist())
        return self.plan.once(("smooth", of), lambda: self._rows("smooth", of, weights, SMOOTH // 2))

    def _recipe(self, channel: WatchChannel, case: Case) -> tuple[Hashable, Callable[[], int]]:
        name, _, what = channel.name.partition(".")
        plan, shape = self.plan, self.shape
        if what in ("spool", "q_in", "p_pump"):
            read = self._read(f"{name}.{what}", case)
            expected = {"spool": self._driven, "q_in": self._flow_in, "p_pump": self._pump_pressure}[what](name, case)
            return (channel, read, expected), lambda: plan.filled(
                shape.inside, "difference", read, expected, shape.before
            )
        if what == "p_out":
            k, out, flow = self._outlet(name, case), self._ports(name, case)[1], self._read(f"{name}.q_out", case)
            valve, rest = case.machine.function(name).valve, case.machine.tank.return_pressure
            numbers = plan.numbers((rest, _LEAST_OUTLET * max(*valve.outlet_positive, *valve.outlet_negative)))
            places = (k, out, flow, shape.before, numbers)
            return (channel, places), lambda: plan.filled(shape.inside, "outlet_pressure", *places)
        if what == "torque":
            parts = self._torque(name, case)
            return (channel, parts), lambda: plan.filled(self.instants, "torque_left", *parts)
        side = self._line(name, what == "volume_a", case)
        return (channel, side), lambda: plan.filled(self.windows, "volume_balance", *side)

    def _driven(self, name: str, case: Case) -> int:
        """Spool that the voltage drives."""
        f, step = case.machine.function(name), self.shape.raster
        voltage = self._read(f"{name}.voltage", case)
        column = f"{name}.spool"
        begins = self._read(column, case) if column in self.columns else -1
        keep = float(np.exp(-step / f.pilot.time_constant))
        second = 1.0 - (1.0 - keep) * f.pilot.time_constant / step
        numbers = self.plan.numbers(
            (f.pilot.gain, f.valve.knots[-1], f.pilot.dead_time / step, keep, 1.0 - keep - second, second, 0.5 * (f.effects.hysteresis or 0.0))
        )  # fmt: skip
        places = (voltage, begins, numbers)
        return self.plan.once(("driven", places), lambda: self._rows("spool_by_voltage", *places))

    def _spool(self, name: str, case: Case) -> int:
        column = f"{name}.spool"
        return self._smooth(self._read(column, case)) if column in self.columns else self._driven(name, case)

    def _pressure(self, column: str, case: Case) -> int:
        read = self._read(column, case)
        return self.plan.once(("pressure", read), lambda: self._rows("not_below_zero", read))

    def _ports(self, name: str, case: Case) -> tuple[int, int]:
        """Pressures at the pressurised port and at the outlet."""
        x, a, b = self._spool(name, case), self._pressure(f"{name}.p_a", case), self._pressure(f"{name}.p_b", case)
        return self._port(x, a, b), self._port(x, b, a)

    def _port(self, *places: int) -> int:
        return self.plan.once(("port", places), lambda: self._rows("port", *places))

    def _flow_in(self, name: str, case: Case) -> int:
        return self._circuits(name, case) + valves_beside(case.machine, name).index(name) * self.shape.rows

    def _pump_pressure(self, circuit: str, case: Case) -> int:
        name = case.machine.circuit(circuit).functions[0]
        pumps = [c.name for c in circuits_beside(case.machine, name)]
        place = len(valves_beside(case.machine, name)) + pumps.index(circuit)
        return self._circuits(name, case) + place * self.shape.rows

    def _circuits(self, name: str, case: Case) -> int:
        """Flows into the actuators of the circuits that a function's depends on, then the pressures of their pumps, one behind the other."""
        machine, functions, x = case.machine, valves_beside(case.machine, name), crossover_of(case.machine, name)
        curves = [machine.function(f).valve for f in functions]
        pumps = [
            limited_pump(c.pump.flow, c.pump.relief, machine.tank.return_pressure, c.pump)
            for c in circuits_beside(machine, name)
        ]
        number = self.plan.numbers([value for pump in pumps for value in pump])
        places = [
            (self._spool(f, case), self._ports(f, case)[0], self.plan.numbers((*v.knots, *v.inlet, *v.bypass)), len(v.knots))
            for f, v in zip(functions, curves, strict=True)
        ]  # fmt: skip
        crossing: tuple[int, ...] = ()
        if x is not None:
            opens = (x.valve.opening_pressure, *curves[-1].knots, *x.valve.conductance)
            crossing = (self.plan.numbers(opens), len(curves[-1].knots))

        def made() -> int:
            rows = self.shape.rows
            out = self.plan.room((len(functions) + len(pumps)) * rows)
            pressures = [out + (len(functions) + k) * rows for k in range(len(pumps))]
            each = [part for k, (spool, p, *curve) in enumerate(places) for part in (spool, p, out + k * rows, *curve)]
            kind = f"{'circuit' if x is None else 'crossing'}_{len(functions)}"
            self.plan.step(kind, self.shape.before, self.shape.inside + 1, number, *pressures, *each, *crossing)
            return out

        return self.plan.once(("circuit", functions, number, tuple(places), crossing), made)

    def _outlet(self, name: str, case: Case) -> int:
        """Conductance of the outlet."""
        valve = case.machine.function(name).valve
        curves = self.plan.numbers((*valve.knots, *valve.outlet_positive, *valve.outlet_negative))
        places = (self._spool(name, case), curves, len(valve.knots))
        return self.plan.once(("outlet", places), lambda: self._rows("opening_of_outlet", *places))

    def _flow_out(self, name: str, case: Case) -> int:
        rest = self.plan.numbers((case.machine.tank.return_pressure,))
        places = (self._outlet(name, case), self._ports(name, case)[1], rest)
        return self.plan.once(("out", places), lambda: self._rows("flow_out", *places))

    def _volumes(self, name: str, case: Case) -> int:
        """Volumes of both sides, and both levers, one behind the other."""
        machine, f = case.machine, case.machine.function(name)
        position = self._smooth(self._read(position_column(machine, f), case))
        rows = self.shape.rows

        def made() -> int:
            if f.pins is None:
                a, b = (float(lever) for lever in levers(machine, f, np.zeros(())))
                kind, places = "straight_volumes", [self.plan.numbers((a, b))]
            else:
                grid = lever_grid(f)
                tables = (*side_volumes(machine, f, grid), *levers(machine, f, grid))
                flat = [grid[0], (grid[-1] - grid[0]) / (len(grid) - 1), *np.concatenate(tables).tolist()]
                kind, places = "tabled_volumes", [self.plan.numbers(flat), len(grid)]
            out = self.plan.room(4 * rows)
            self.plan.step(kind, out, rows, position, *places)
            return out

        return self.plan.once(("volumes", name, f.drive, case.mechanics, position), made)

    def _line(self, name: str, side_a: bool, case: Case) -> tuple[int, ...]:
        """Places of a balance of one side."""
        line, shape = case.machine.function(name).line, self.shape
        x, volumes = self._spool(name, case), self._volumes(name, case)
        a, b = self._pressure(f"{name}.p_a", case), self._pressure(f"{name}.p_b", case)
        into = self._read(f"{name}.q_in", case) if f"{name}.q_in" in self.columns else self._flow_in(name, case)
        out = self._read(f"{name}.q_out", case) if f"{name}.q_out" in self.columns else self._flow_out(name, case)
        own, other, volume = (a, b, volumes) if side_a else (b, a, volumes + shape.rows)
        compliance = line.compliance_a if side_a else line.compliance_b
        numbers = self.plan.numbers(
            (shape.window * shape.raster, line.leakage, line.external_leakage, compliance, line.relief, _RELIEF_BAND, _LEAST_LOSS)
        )  # fmt: skip
        smoothed = self._smooth(own)
        return (volume, own, smoothed, other, x, into, out, shape.before, shape.window, int(side_a), numbers)

    def _motion(self, case: Case) -> list[tuple[int, int, int]]:
        """Where position, rate and acceleration of each joint at the instants stand."""
        reads = [self._read(position_column(case.machine, f), case) for f in case.machine.functions]
        return [(self._convolved(read, 0), self._convolved(read, 1), self._convolved(read, 2)) for read in reads]

    def _convolved(self, of: int, k: int) -> int:
        places = (
            of,
            self.plan.numbers(self.filters[k].tolist()),
            2 * self.half + 1,
            self.shape.before - self.half,
            self.stride,
        )
        return self.plan.once(("convolved", places), lambda: self.plan.filled(self.instants, "convolved", *places))

    def _torque(self, name: str, case: Case) -> tuple[int, int, int]:
        """Torque of the oil, friction, and torque that the motion needs."""
        plan, f, place = self.plan, case.machine.function(name), case.machine.names.index(name)
        motion = self._motion(case)
        a, b = self._pressure(f"{name}.p_a", case), self._pressure(f"{name}.p_b", case)
        lever_a = self._volumes(name, case) + 2 * self.shape.rows
        weights, long = plan.numbers(self.filters[0].tolist()), 2 * self.half + 1
        places = (lever_a, a, lever_a + self.shape.rows, b, weights, long, self.shape.before - self.half, self.stride)
        oil = plan.once(("oil", places), lambda: plan.filled(self.instants, "oil_torque", *places))
        rubbed = (motion[place][1], plan.numbers(_friction_numbers(f.friction)))
        friction = plan.once(("friction", rubbed), lambda: plan.filled(self.instants, "friction", *rubbed))
        key = ("needed", case.mechanics, case.machine.gravity, case.payload, *motion)
        needed = plan.once(key, lambda: self._needed(case, motion))
        return oil, friction, needed + place * self.instants

    def _needed(self, case: Case, motion: list[tuple[int, int, int]]) -> int:
        """Torque that a motion needs of each function, one behind the other."""
        machine = with_payload(case.machine, case.payload) if case.payload else case.machine
        names, numbers, places = [f.moves for f in machine.functions], [machine.gravity], list[int]()
        for f, moved in zip(machine.functions, motion, strict=True):
            link = machine.link(f.moves)
            sign = -1.0 if link.axis[0] == "-" else 1.0
            numbers += [*vector(link.at), link.mass, *vector(link.cg), *tensor_of(link).ravel(), sign]
            parent = names.index(link.parent) if link.parent in names else -1
            places += [parent, AXES[link.axis[-1]], int(link.joint == "prismatic"), *moved]
        room = self.plan.room(len(names) * ROOM_OF_LINK)
        out = self.plan.room(len(names) * self.instants)
        self.plan.step("needed_torques", out, self.instants, len(names), self.plan.numbers(numbers), room, *places)
        return out


def _friction_numbers(f: Friction | SlideFriction) -> tuple[float, ...]:
    return (f.coulomb, f.static, f.stribeck, f.viscous, f.smoothing)
