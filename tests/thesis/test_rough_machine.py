import numpy as np
import pytest

from polydraulic.parameters.load import load_machine
from polydraulic.thesis.rough_machine import rough_machine


def test_a_rough_machine_knows_edges_and_is_off_in_what_is_to_be_identified():
    machine = load_machine("wheel_loader")
    rough = rough_machine(machine, np.random.default_rng(1))
    assert rough == rough_machine(machine, np.random.default_rng(1))
    assert rough != rough_machine(machine, np.random.default_rng(2))
    assert rough.circuits[0].pump.flow == pytest.approx(1.05 * machine.circuits[0].pump.flow)
    for f, true in zip(rough.functions, machine.functions, strict=True):
        knots = true.valve.knots
        assert f.valve.knots == pytest.approx((0.0, knots[1], knots[-2], knots[-1]))
        assert f.pilot.gain == pytest.approx(1.1 * true.pilot.gain)
        assert f.pilot.time_constant == pytest.approx(0.8 * true.pilot.time_constant)
        for key in ("inlet", "bypass", "outlet_positive", "outlet_negative"):
            at = np.interp(f.valve.knots, knots, getattr(true.valve, key))
            off = np.array(getattr(f.valve, key))[at > 0.0] / at[at > 0.0]
            assert np.all((off >= 0.6 - 1e-12) & (off <= 1.5 + 1e-12)), key
            assert np.all(np.abs(off - 1.0) > 1e-6), key
        assert (f.moves, f.line, f.friction) == (true.moves, true.line, true.friction)
