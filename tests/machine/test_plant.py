import math

import pytest

from polydraulic.errors import InputError
from polydraulic.machine.plant import prepare


@pytest.mark.parametrize("dt", [0.0, -0.005, math.nan, math.inf])
def test_step_size_must_be_positive(machine, dt):
    with pytest.raises(InputError, match="time step must be positive"):
        prepare(machine, dt)
