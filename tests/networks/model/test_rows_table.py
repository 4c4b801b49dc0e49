import numpy as np
import pytest
from hypothesis import given

from helpers.random_networks import model_of, networks
from polydraulic.errors import InputError
from polydraulic.networks import Network
from polydraulic.networks.model.model import pack_models
from polydraulic.networks.model.partition import choose
from polydraulic.networks.model.table import evaluate, work_size


@given(networks(n_input=2), networks(n_input=2), networks(n_input=2))
def test_many_rows_have_the_bits_of_one(a, b, c):
    model = model_of(a, b, c, edges={0: (-0.2, 0.7)})
    X = np.random.default_rng(3).uniform(-1.5, 2.0, size=(150, 2))
    (regions,), table = pack_models([model])
    work, one_by_one = np.zeros(work_size(table)), []
    for row in X:
        work[:2] = row
        one_by_one.append(evaluate(table, choose(regions, work), work))
    assert np.array_equal(model.predict(X), one_by_one, equal_nan=True)


def test_bad_rows_are_named():
    model = model_of(Network((), (0.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), 2.0, 1.0))
    assert model.predict(np.zeros((2, 2))).tolist() == [2.0, 2.0]
    with pytest.raises(InputError, match=r"must be \(n_row, 2\)"):
        model.predict(np.zeros((2, 3)))
    with pytest.raises(InputError, match="x1 = nan in row 1"):
        model.predict(np.array([[0.0, 0.0], [0.0, np.nan]]))
