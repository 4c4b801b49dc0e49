import math

import pytest

from polydraulic.machine.pilot import pilot_step, prepare_pilot


@pytest.mark.parametrize("voltage", [0.3, -0.5, 5.0])
def test_pilot_is_the_exact_first_order_answer(machine, voltage):
    pilot = machine.boom.pilot
    prepared = prepare_pilot(pilot, machine.spool.knots[-1], 0.005)
    x = 0.0
    for _ in range(40):
        x = pilot_step(x, voltage, prepared)
    target = max(-machine.spool.knots[-1], min(machine.spool.knots[-1], pilot.gain * voltage))
    assert x == pytest.approx(target * (1.0 - math.exp(-0.2 / pilot.time_constant)), rel=1e-12)
