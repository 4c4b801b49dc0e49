import numpy as np
import pytest

from polydraulic import AbductiveRegressor, build_flow
from polydraulic.flow import (
    FLOW_KINDS,
)
from polydraulic.thesis.boom_models import fit_columns
from polydraulic.thesis.excavator import sample_boom, spool_of


@pytest.fixture(scope="module", params=[name for name in FLOW_KINDS if name != "residual"])
def model(request, machine, build):
    if request.param != "pressure":
        return build(request.param, machine)
    table = sample_boom(machine, 400, rng=np.random.default_rng(1), relief=False)
    edges = {0: [spool_of(machine).deadband, spool_of(machine).bypass_closed]}
    pressure = fit_columns(AbductiveRegressor(max_layers=2), table, ["boom.travel", "boom.p_in"], "boom.p_pump", edges)
    return build_flow("pressure", machine, models=[pressure])
