"""Networks in a machine of any layout: the bits of those written by hand for cat215b, and what does not fit is named."""

import pytest

from helpers.excavator_tree import excavator_tree
from polydraulic import InputError, build_flow, load_machine, simulate
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import Model
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant

TREE = excavator_tree()


@pytest.mark.slow_to_compile
def test_networks_of_one_circuit_serve_what_moves_no_other():
    models = [model for model in shipped_models("cascade") if model.output.name.startswith("boom.")]
    flow = build_flow("polynomial", TREE, models=models)
    assert flow.served == ("boom",)
    with pytest.raises(InputError, match="moves swing, stick, for which flow 'polynomial' has no networks; lock them"):
        simulate(TREE, flow, "task", t_end=0.1)
    alone = Scenario("boom alone", 0.4, {"boom": Constant(0.8)}, locked=("swing", "stick"))
    run = simulate(TREE, flow, alone)
    assert run["boom.q_in"].max() > 0.0
    assert "boom.p_pump" not in run.names  # networks do not know it
    with pytest.raises(InputError, match="energy account needs pressures of pumps, which flow 'polynomial' does not"):
        simulate(TREE, flow, alone, t_end=0.1, energy=True)


def renamed(models, changes):
    return [
        Model(m.inputs, m.output, m.networks, m.partition)
        if m.output.name not in changes
        else Model(changes[m.output.name], m.output, m.networks, m.partition)
        for m in models
    ]


SHIPPED = shipped_models("cascade")


@pytest.mark.parametrize(
    ("models", "words"),
    [
        ([m for m in SHIPPED if m.output.name != "swing.k_out"], "needs one model of swing.k_out"),
        (
            renamed(SHIPPED, {"stick.q_in": SHIPPED[0].inputs * 3}),
            "the circuit needs one of .*series.q_passed.* or .*swing.travel",
        ),
        (
            [Model(m.inputs, type(m.output)(f"x.{m.output.name}"), m.networks, m.partition) for m in SHIPPED],
            "needs those of all functions of a circuit: boom: boom; series: swing, stick",
        ),
    ],
)
def test_what_is_missing_is_named(models, words):
    with pytest.raises(InputError, match=words):
        build_flow("polynomial", TREE, models=models)


def test_a_model_of_one_machine_is_refused_to_another(machine):
    flow = build_flow("polynomial", TREE, models=SHIPPED)
    with pytest.raises(
        InputError, match="is for the circuits boom \\(boom\\); series \\(swing, stick\\); this machine"
    ):
        simulate(load_machine("wheel_loader"), flow, "wheel_loader_cycle")
    with pytest.raises(InputError, match="dict is not a flow model; choose one of"):
        simulate(machine, {}, "task")
