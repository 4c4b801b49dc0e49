"""Networks in both of their forms: in tables, and as machine code."""

import pickle

import numba
import numpy as np
import pytest

from polydraulic import build_flow, load_scenario, simulate
from polydraulic.flow.layout.network_parts import NumberedNetworks
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks.model.machine_code import NetworkCode
from polydraulic.networks.model.partition import Regions
from polydraulic.networks.model.table import NetworkTable
from polydraulic.simulation.layout.prepare import prepare_layout

COMPILED = not numba.config.DISABLE_JIT


def test_kernels_get_machine_code_where_there_is_a_compiler_and_exports_get_tables(machine):
    flow = build_flow("polynomial", machine)
    running = prepare_layout(machine, 5e-3, flow=flow).valves
    assert isinstance(running.table, NetworkCode if COMPILED else NetworkTable)
    assert isinstance(running.networks_boom.q_in, int if COMPILED else Regions)
    exported = prepare_layout(machine, 5e-3, flow=flow, in_tables=True).valves
    assert isinstance(exported.table, NetworkTable)
    assert isinstance(exported.networks_boom.q_in, Regions)
    assert exported.networks_boom.closes == running.networks_boom.closes


@pytest.mark.skipif(not COMPILED, reason="needs the compiler")
def test_code_is_made_when_it_is_first_asked_for_and_goes_to_no_other_process(machine):
    models = [model for model in shipped_models() if model.output.name.startswith("boom.")]
    flow = build_flow("polynomial", machine, models=models)
    assert flow.networks._code is None
    assert flow.running_parts is flow.running_parts
    other = pickle.loads(pickle.dumps(flow))
    assert isinstance(other.networks, NumberedNetworks)
    assert other.networks._code is None
    scenario = load_scenario("single_08")
    runs = [simulate(machine, one, scenario, t_end=0.2) for one in (flow, other)]
    assert all(np.array_equal(runs[0][name], runs[1][name]) for name in runs[0].names)
