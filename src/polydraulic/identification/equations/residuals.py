"""What identified circuits leave of measured flows, as bounded networks, kept only where blocks of time held out get better.

A run has no measured spool: its pilots drive the spools. What flow forces, friction and whatever else put between the driven spool and the
measured one is a flow that the circuit does not have at the driven spool. It is that flow which a network learns, from travels and pressures as a
run has them.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.slots import residual
from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, flows_of
from polydraulic.identification.equations.fit.jets import jets_of
from polydraulic.identification.equations.fit.valve_curves import Curves
from polydraulic.identification.equations.identify import Identification
from polydraulic.identification.equations.observations import blocks_of_time
from polydraulic.identification.equations.sensors import read_function
from polydraulic.identification.equations.spool_motion import driven_spool, pieces_of
from polydraulic.identification.equations.ways.by_spools import STEP_LAG, declared_effects
from polydraulic.identification.log_pieces import raster_segments, raster_within
from polydraulic.machine.pump import limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model
from polydraulic.networks.proof.bounds import model_bounds
from polydraulic.pages.text import text_table
from polydraulic.parameters.layout.parts import SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

ROWS = 8000  # that a network learns from
RESIDUAL_HEADS = ("function", "left before, of the pump", "with a network", "proved range", "kept")
_LEAST_ROWS, _LEAST_BLOCKS = 200, 3
_BELOW = 0.95  # of the relief setting: above, noise of the pressure decides what flows
# share of the squares held out that a network must save, and of blocks held out that must get better
_WORTH, _MOST = 0.1, 0.5
_TAIL = 1e-3  # share of residuals on either side beyond the bounds of a network


class Residual(NamedTuple):
    """What is left of the flow into a function, as a share of its pump's flow, root mean square over blocks held out.

    Attributes
    ----------
    function : str
    before, after : float
        Without the network and with it.
    low, high : float
        Proved range of the network, as a share, too.
    kept : bool
    """

    function: str
    before: float
    after: float
    low: float
    high: float
    kept: bool


class ResidualModels(NamedTuple):
    """Networks for `residual_flow`, and how good each is.

    Attributes
    ----------
    models : list of Model
        Those that are kept.
    judged : list of Residual
    lacks : list of str
        Circuits that have none, and why.
    """

    models: list[Model]
    judged: list[Residual]
    lacks: list[str]

    def __str__(self) -> str:
        """What was learnt, in lines."""
        rows = [
            [r.function, f"{r.before:.2%}", f"{r.after:.2%}", f"{r.low:.1%} to {r.high:.1%}", "yes" if r.kept else "no"]
            for r in self.judged
        ]
        head = "flows that circuits do not have at the driven spools, on blocks of time held out:"
        return "\n".join([*([head, *text_table(RESIDUAL_HEADS, rows)] if rows else []), *self.lacks])


def learn_residuals(found: Identification, *, progress: Progress = quiet) -> ResidualModels:
    """Learn what identified circuits leave of measured flows.

    A network is judged on every fifth block of time, and kept where it saves a tenth of the squares there and most blocks get better; what is kept has
    learnt from all rows. It never gives more than residuals of its log were, but for a thousandth on either side.

    Parameters
    ----------
    found : Identification
    progress : Progress, optional

    Raises
    ------
    InputError
        A log of which no circuit has voltages, spools, pressures and flows of all functions.
    """
    machine, models, judged, lacks = found.machine, list[Model](), list[Residual](), list[str]()
    total = len(machine.functions)
    for circuit in machine.circuits:
        read = _read_of(circuit)
        missing = [name for name in read if name not in found.table.names]
        if missing:
            lacks.append(f"circuits.{circuit.name}: no network of what is left; the log has no {', '.join(missing)}")
            continue
        log = found.table.whole(["time", *(name for name in found.table.names if name == "segment"), *read])
        at, off = residual_rows(machine, circuit, log)
        time = log["time"]
        for place, name in enumerate(circuit.functions):
            progress(f"{name}: what is left", len(judged), total)
            rows = np.flatnonzero(np.isfinite(off[:, place]))
            made = _learnt(machine, circuit, name, at[rows], off[rows, place], time[rows])
            if made is None:
                lacks.append(f"functions.{name}: no network of what is left; too few rows with an open valve")
                continue
            judged.append(made[0])
            models += [made[1]] if made[0].kept else []
    if not judged:
        raise InputError("; ".join(lacks))
    progress("residuals", total, total)
    return ResidualModels(models, judged, lacks)


def residual_rows(machine: LayoutMachine, circuit: SupplyCircuit, log: Table) -> tuple[np.ndarray, np.ndarray]:
    """What networks of a circuit read, and flows that it does not have at the driven spools.

    Returns
    -------
    (n_row, 2 n) array
        Travels that voltages drive the spools to, m, and pressures at the ports that they pressurise, Pa.
    (n_row, n) array, m3/s
        Measured flow less that of the circuit; nan where the circuit lets nothing in, or near relief.
    """
    time = log["time"]
    segment = raster_segments(log)
    pieces, step = pieces_of(segment), raster_within(time, segment)
    travel, p_in = (np.empty((len(time), len(circuit.functions))) for _ in range(2))
    jets = _jets(machine, circuit, log, segment, step)
    for k, name in enumerate(circuit.functions):
        f = machine.function(name)
        pilot = f.pilot._replace(dead_time=f.pilot.dead_time + STEP_LAG)
        voltage, spool = log[f"{name}.voltage"], log[f"{name}.spool"]
        does = declared_effects(f)
        driven = driven_spool(pilot, f.valve.knots[-1], time, pieces, voltage, spool, step, does, jets.get(name))
        travel[:, k] = np.abs(driven)
        p_in[:, k] = np.maximum(np.where(driven > 0.0, log[f"{name}.p_a"], log[f"{name}.p_b"]), 0.0)
    valves = [machine.function(name).valve for name in circuit.functions]
    curves = tuple(Curves(*(np.array(part) for part in (v.knots, v.inlet, v.bypass))) for v in valves)
    pump = limited_pump(circuit.pump.flow, circuit.pump.relief, machine.tank.return_pressure, circuit.pump)
    flows = flows_of(CircuitModel(curves, pump), travel, p_in)
    measured = np.column_stack([log[f"{name}.q_in"] for name in circuit.functions])
    opens = np.array([spool_edges(v)[0] for v in valves])
    told = (travel > opens) & (flows > 0.0) & (p_in < _BELOW * circuit.pump.relief)
    return np.hstack([travel, p_in]), np.where(told, measured - flows, np.nan)


def _jets(
    machine: LayoutMachine, circuit: SupplyCircuit, log: Table, segment: np.ndarray, raster: float
) -> dict[str, np.ndarray]:
    """Jets of functions, where one at least declares that they push its spool back."""
    if all(machine.function(name).effects.flow_force is None for name in circuit.functions):
        return {}
    signals = {
        name: read_function(machine, machine.function(name), log, segment, raster, False) for name in circuit.functions
    }
    return {name: jets.strength for name, jets in jets_of(machine, circuit, signals, segment, {}, {}).items()}


def _read_of(circuit: SupplyCircuit) -> list[str]:
    """Columns of a log that flows of a circuit are compared in."""
    return [f"{name}.{what}" for name in circuit.functions for what in ("voltage", "spool", "p_a", "p_b", "q_in")]


def _learnt(
    machine: LayoutMachine, circuit: SupplyCircuit, name: str, at: np.ndarray, off: np.ndarray, time: np.ndarray
) -> tuple[Residual, Model] | None:
    """How good a network is on blocks held out, and one of all rows."""
    block, rng, flow = blocks_of_time(time), np.random.default_rng(0), circuit.pump.flow
    hold = block % 5 == 4
    if min(hold.sum(), (~hold).sum()) < _LEAST_ROWS or len(np.unique(block[hold])) < _LEAST_BLOCKS:
        return None
    low, high = np.quantile(off, (_TAIL, 1.0 - _TAIL)).tolist()

    def grown(rows: np.ndarray) -> AbductiveRegressor:
        some = rng.permutation(rows)[:ROWS]
        return AbductiveRegressor(output_bounds=(low, high)).fit(at[some], off[some])

    left = off[hold] - grown(np.flatnonzero(~hold)).predict(at[hold])
    blocks = [_block_squares(values, block[hold]) for values in (off[hold], left)]
    better = np.mean(blocks[1] < blocks[0])
    kept = bool(np.sum(left**2) < (1.0 - _WORTH) * np.sum(off[hold] ** 2) and better > _MOST)
    output, inputs = residual(circuit, name)
    model = grown(np.arange(len(off))).to_model(inputs, output)
    proved = model_bounds(model)
    before, after = (float(np.sqrt(np.mean(values**2)) / flow) for values in (off[hold], left))
    return Residual(name, before, after, proved.low / flow, proved.high / flow, kept), model


def _block_squares(values: np.ndarray, block: np.ndarray) -> np.ndarray:
    _, number = np.unique(block, return_inverse=True)
    return np.asarray(np.bincount(number, values * values))
