"""Networks that name faults: what they read, and what they say with which certainty."""

from dataclasses import replace

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.networks import Model, Variable
from polydraulic.networks.model.nodes import KIND_NAMES
from polydraulic.networks.model.partition import Split
from polydraulic.networks.model.table import Network, Node
from polydraulic.watch.directions import directions_of
from polydraulic.watch.naming import FaultNetworks, features, inputs_of, kinds_of
from polydraulic.watch.sequential import Since

DIRECTIONS = directions_of(load_machine("wheel_loader"), frozenset(["lift.p_a", "tilt.p_a"]))
KINDS, INPUTS = kinds_of(DIRECTIONS), inputs_of(DIRECTIONS)


def seen(**amounts):
    """Sums over 20 blocks in which these directions are pulled so far, with an information of 100 each."""
    pull = np.array([100.0 * amounts.get(d.name.replace(".", "_"), 0.0) for d in DIRECTIONS])
    return Since(pull, np.full(len(pull), 100.0), pull**2 / 100.0, 20)


def reads(kind):
    """A network whose output is the share of a kind in the evidence."""
    n, place = len(INPUTS), KINDS.index(kind)
    node = Node(KIND_NAMES.index("single"), (place,), (0.0, 1.0, 0.0, 0.0))
    network = Network((node,), (0.0,) * n, (1.0,) * n, (-4.0,) * n, (3.0,) * n, 0.0, 1.0)
    return Model(tuple(map(Variable, INPUTS)), Variable(kind), (network,))


@pytest.fixture
def networks():
    models = tuple(map(reads, ("pump_worn", "leak_across", "bias")))
    return FaultNetworks(tuple(d.name for d in DIRECTIONS), models, np.column_stack([5.0 * np.eye(3), [0.0, 0.0, 0.0]]))


def test_features_are_shares_of_the_most_evidence_whatever_there_is_of_it():
    few, many = (features(DIRECTIONS, seen(work_pump_worn=a, lift_leak_across=0.5 * a), 1.0) for a in (1.0, 2.0))
    assert few.shape == (len(INPUTS),)
    assert few[KINDS.index("pump_worn")] == 1.0
    assert few[KINDS.index("leak_across")] == pytest.approx(0.5)
    assert few[: len(KINDS)] == pytest.approx(many[: len(KINDS)])
    assert few[INPUTS.index("evidence")] == pytest.approx(np.log10(50.0))
    assert many[INPUTS.index("evidence")] == pytest.approx(np.log10(200.0))


def test_scatter_tells_what_explains_every_block_from_what_explains_some():
    whole = seen(work_pump_worn=1.0)
    some = whole._replace(squares=whole.squares + 19.0 * 8.0)
    place = INPUTS.index("scatter of pump_worn")
    assert features(DIRECTIONS, some, 2.0)[place] == pytest.approx(np.log10(4.0))
    assert features(DIRECTIONS, whole, 2.0)[place] == pytest.approx(-3.0)


def test_of_a_kind_the_strongest_counts_and_what_would_go_the_wrong_way_does_not():
    found = features(DIRECTIONS, seen(lift_leak_across=1.0, tilt_leak_across=0.2, work_pump_worn=-4.0), 2.0)
    assert found[KINDS.index("leak_across")] == 1.0
    assert found[KINDS.index("pump_worn")] == 0.0
    assert np.isfinite(features(DIRECTIONS, seen(), 1.0)).all()


def test_the_certainty_is_that_of_the_link(networks):
    opinion = networks.opinion(DIRECTIONS, seen(lift_leak_across=1.0, work_pump_worn=0.5), 1.0)
    assert opinion.kind == "leak_across"
    likely = np.exp(5.0 * np.array([0.5, 1.0, 0.0]))
    assert opinion.certainty == pytest.approx(likely[1] / likely.sum())
    assert opinion.known
    assert networks.kinds == ("pump_worn", "leak_across", "bias")


def test_evidence_beyond_what_was_learnt_is_said_to_be(networks):
    assert not networks.opinion(DIRECTIONS, seen(work_pump_worn=40.0), 1.0).known


def test_networks_of_other_faults_and_of_regions_are_refused(networks):
    with pytest.raises(InputError, match="learnt for other faults"):
        networks.asked(DIRECTIONS[1:])
    first, *others = networks.models
    split = Model(first.inputs, first.output, first.networks * 2, Split(0, 0.5, 0, 1))
    with pytest.raises(InputError, match="of pump_worn has regions"):
        replace(networks, models=(split, *others)).asked(DIRECTIONS)
