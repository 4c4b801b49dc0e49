"""Networks that are asked: the outputs of their models, the kind that these make likely, and the same bits without the compiler."""

import numpy as np
import pytest

from helpers.watched_logs import made_networks
from polydraulic import load_machine
from polydraulic._kernel import in_plain_python
from polydraulic.watch.directions import directions_of
from polydraulic.watch.kernels.opinions import opinion_of

DIRECTIONS = directions_of(load_machine("wheel_loader"), frozenset(["lift.p_a", "tilt.p_a"]))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_likeliest_kind_is_named_in_plain_python_with_the_same_bits(seed):
    networks = made_networks(DIRECTIONS, seed)
    numbers, room, slots = networks.asked(DIRECTIONS)
    rng, n = np.random.default_rng(seed), len(DIRECTIONS)
    information = rng.uniform(0.0, 40.0, n)
    pull = rng.normal(size=n) * information
    sums, down = (
        np.concatenate([pull, information, 2.0 * pull**2 / information]),
        np.array([int(d.both) for d in DIRECTIONS]),
    )
    said = opinion_of(numbers, sums, 0, 20, 1.3, down, room, slots)
    kept, reads = room.copy(), room[: numbers.inputs].copy()
    assert in_plain_python(opinion_of)(numbers, sums, 0, 20, 1.3, down, room, slots) == said
    assert np.array_equal(kept, room)
    outputs = np.array([model.predict(reads[None, :])[0] for model in networks.models])
    assert np.array_equal(room[numbers.inputs :][: len(outputs)], outputs)
    likely = np.exp(networks.link[:, :-1] @ outputs + networks.link[:, -1])
    assert said.kind == np.argmax(likely)
    assert said.certainty == pytest.approx(likely.max() / likely.sum(), rel=1e-12)
    assert said.familiar == networks.models[said.kind].inside(reads[None, :])[0]
