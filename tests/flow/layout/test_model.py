"""Which flow models know which circuits, and what a refusal says."""

import pytest

from polydraulic import InputError, build_flow, load_machine
from polydraulic.flow import FLOW_KINDS
from polydraulic.flow.layout.model import KNOWN_CIRCUITS, flows_for


def test_every_flow_model_says_which_circuits_it_knows():
    assert list(KNOWN_CIRCUITS) == list(FLOW_KINDS)


@pytest.mark.parametrize("name", [name for name in FLOW_KINDS if name != "exact"])
def test_a_crossover_is_refused_by_name_and_what_serves_it_is_said(name):
    words = rf"flow '{name}' is for circuits of .*valves in series; circuit 'main_giving' is of the kind 'crossover': use 'exact'$"
    with pytest.raises(InputError, match=words):
        build_flow(name, "cat215b_crossover")
    assert flows_for(load_machine("cat215b_crossover")) == ["exact"]


@pytest.mark.parametrize("name", ["iterative", "stiff", "lookup"])
def test_longer_circuits_are_refused_by_those_that_know_two_valves(name):
    able = r"\['exact', 'tlm', 'polynomial', 'neural', 'pressure', 'residual'\]"
    words = rf"'{name}' is for circuits of at most 2 valves in series; circuit 'arm' has 3 \(swing, stick, bucket\): use one of {able}"
    with pytest.raises(InputError, match=words):
        build_flow(name, "excavator_22t")


@pytest.mark.parametrize("machine", ["wheel_loader", "cat215b_bucket", "excavator_22t"])
def test_what_is_said_to_know_the_circuits_does(machine):
    for name in flows_for(load_machine(machine)):
        if name in ("polynomial", "polynomial-fine", "neural", "pressure", "residual"):
            with pytest.raises(InputError, match="models"):
                build_flow(name, machine)
        else:
            assert build_flow(name, machine, **({"points": 6} if name == "lookup" else {})).name == name
