import pytest

from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.flow.layout.slots import everything, inlet_limited, outlet, second_at_relief
from polydraulic.flow.network_slots import choose_model, k_in, k_out, q_in
from polydraulic.networks import Model, Network, Node, Variable

BOOM, SERIES = (load_machine("cat215b").circuit(name) for name in ("boom", "series"))
BOOM_IN, BOOM_OUT = (q_in("boom"), everything(BOOM.functions)), outlet("boom")[1]
BOOM_LIMITED, STICK_RELIEF = inlet_limited(BOOM, "boom"), second_at_relief(SERIES)


def model(output, inputs):
    n = len(inputs)
    zero, one = (0.0,) * n, (1.0,) * n
    network = Network((Node(0, (0,), (0.0, 1.0, 0.0, 0.0)),), zero, one, zero, one, 0.0, 1.0)
    return Model(tuple(inputs), output, (network,))


def test_modes_are_endings_of_names():
    assert q_in("boom").name == "boom.q_in"
    assert BOOM_LIMITED[0].name == "boom.q_in_limited"
    assert STICK_RELIEF[0].name == "stick.q_in_relief"
    assert (k_in("swing")[0].unit, k_out("swing").unit) == ("m3/s/Pa^0.5",) * 2


def test_a_model_is_found_by_its_output_and_what_it_reads():
    inlet, outlet = model(*BOOM_IN), model(*BOOM_OUT)
    assert choose_model([outlet, inlet], BOOM_IN) is inlet
    assert choose_model([outlet, inlet], (k_out("boom"), BOOM_IN[1][:1]), BOOM_OUT) is outlet
    bare = model(Variable("boom.q_in"), [Variable(variable.name) for variable in BOOM_IN[1]])
    assert choose_model([bare], BOOM_IN) is bare  # without units they are taken as they are


@pytest.mark.parametrize(
    ("models", "message"),
    [
        ([], "needs one model of boom.q_in; given are \\[\\]"),
        ([model(*BOOM_IN)] * 2, "given are \\['boom.q_in', 'boom.q_in'\\]"),
        ([model(BOOM_IN[0], BOOM_IN[1][::-1])], "in this order"),
        ([model(Variable("boom.q_in", "l/min"), BOOM_IN[1])], "boom.q_in \\[l/min\\]; the circuit computes in SI"),
    ],
)
def test_what_does_not_fit_is_named(models, message):
    with pytest.raises(InputError, match=message):
        choose_model(models, BOOM_IN)
