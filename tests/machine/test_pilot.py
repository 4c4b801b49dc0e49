import math

import pytest

from polydraulic.machine.pilot import pilot_step, prepare_pilot
from polydraulic.thesis.excavator import spool_of


@pytest.mark.parametrize("voltage", [0.3, -0.5, 5.0])
def test_pilot_is_the_exact_first_order_answer(machine, voltage):
    pilot = machine.function("boom").pilot
    prepared = prepare_pilot(pilot, spool_of(machine).end, 0.005)
    x = 0.0
    for _ in range(40):
        x = pilot_step(x, voltage, prepared)
    target = max(-spool_of(machine).end, min(spool_of(machine).end, pilot.gain * voltage))
    assert x == pytest.approx(target * (1.0 - math.exp(-0.2 / pilot.time_constant)), rel=1e-12)
