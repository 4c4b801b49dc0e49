"""A log whose boom has a spool that lags behind its pilot and that its jets push back; all else is that of `machine_log`."""

from functools import cache

import numpy as np

from helpers.machine_log import NOISE, machine_log
from polydraulic import load_machine
from polydraulic.identification.equations.fit.jets import jets_of
from polydraulic.identification.equations.sensors import Signals
from polydraulic.identification.equations.spool_motion import SpoolEffects, driven_spool
from polydraulic.machine.play import prepare_shift
from polydraulic.parameters.layout.parts import FlowForce
from polydraulic.tables import Table

LAG, SPRING = 3e-4, FlowForce(8e4, 870.0, np.radians(69.0))
_RASTER = 0.02  # s


@cache
def lagging_log():
    """Columns of the boom, flows left out, which would be those of the spool that does not lag."""
    machine, log = load_machine("cat215b"), machine_log(120.0)
    f, circuit = machine.function("boom"), machine.circuit("boom")
    time, voltage, spool = log["time"], log["boom.voltage"], log["boom.spool"]
    read = {"p_a": log["boom.p_a"], "p_b": log["boom.p_b"]}
    does = SpoolEffects(LAG, prepare_shift(SPRING))
    pieces, start = np.array([[0, len(time)]]), np.zeros(len(time))
    for _ in range(20):  # until jets are those of the spool that they push
        signals = {"boom": Signals(read | {"spool": spool}, {}, dict.fromkeys(read, 5e4))}
        jets = jets_of(machine, circuit, signals, log["segment"], {}, {})["boom"].strength
        before = spool
        spool = driven_spool(f.pilot, f.valve.knots[-1], time, pieces, voltage, start, _RASTER, does, jets)
    assert np.abs(spool - before).max() < 1e-5
    noisy = spool + np.random.default_rng(5).normal(0.0, NOISE["spool"], len(time))
    names = ["time", "segment", "boom.voltage", "boom.p_a", "boom.p_b"]
    return Table({name: log[name] for name in names} | {"boom.spool": noisy}, log.units)
