import numpy as np
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.networks import Variable, learn_from
from polydraulic.networks.regions.learn_from import _points

FLOW = 171.5
quick = AbductiveRegressor(max_layers=2, n_survivors=4)


def kink(X):
    return np.maximum(X[:, 0] - 0.3, 0.0) * (1.0 + X[:, 1])


def valve(steep):
    """Flow of a pump (in3/s) into an actuator, of spool travel (in) and line pressure (psi), past an open bypass."""

    def flow(X):
        inlet = np.interp(X[:, 0], [0.0, 0.188, 0.376, 0.564], [0.0, 0.0, 44.0, 88.0] if steep else [0, 0, 4.6, 9.2])
        bypass = np.interp(X[:, 0], [0.0, 0.188, 0.376, 0.564], [16.0, 5.219 if steep else 3.914, 0.0, 0.0]) ** 2
        drop = X[:, 1] - 50.0
        root = np.sqrt(np.maximum(bypass * (FLOW**2 + (inlet**2 - bypass) * drop), 0.0))
        return np.clip(inlet * (FLOW**2 - bypass * drop) / (inlet * FLOW + root + 1e-300), 0.0, FLOW)

    return flow


def grid(box, n):
    return np.stack(np.meshgrid(*[np.linspace(*ends, n) for ends in box]), axis=-1).reshape(-1, len(box))


def test_a_kink_is_cut_where_it_is():
    box = [(0.0, 1.0), (0.0, 1.0)]
    found = learn_from(kink, box, tolerance=0.01, rows=300, estimator=quick, output=Variable("q", "m3/s"))
    assert found.converged
    assert found.model.partition.at == pytest.approx(0.3, abs=0.02)
    assert np.abs(found.model.predict(grid(box, 101)) - kink(grid(box, 101))).max() <= 0.01
    assert found.largest == pytest.approx(abs(found.model.predict(found.where[None]) - kink(found.where[None]))[0])
    assert found.model.output == Variable("q", "m3/s")
    assert found.model.training["n_evaluations"] == found.n_evaluations
    assert found.model.domain().tolist() == [[0.0, 1.0], [0.0, 1.0]]


def test_a_budget_ends_the_search():
    asked = []

    def counted(X):
        asked.append(len(X))
        return np.sin(9.0 * X[:, 0]) * np.cos(7.0 * X[:, 1])

    found = learn_from(counted, [(0, 1), (0, 1)], tolerance=1e-9, budget=60_000, rows=200, estimator=quick)
    assert not found.converged
    assert found.n_evaluations == sum(asked) <= 60_000
    assert len(found.model.networks) > 1
    few = learn_from(counted, [(0, 1), (0, 1)], tolerance=1e-9, max_regions=2, rows=200, estimator=quick)
    assert len(few.model.networks) == 2


def test_a_seed_gives_the_same_model():
    box = [(0.0, 1.0), (0.0, 1.0)]
    one, same, other = (
        learn_from(kink, box, tolerance=0.1, rows=200, estimator=quick, random_state=seed).model for seed in (1, 1, 2)
    )
    assert one == same
    assert one != other


@pytest.mark.parametrize("n_input", [1, 2, 3])
def test_points_cover_faces_and_corners(n_input):
    cell = np.array([[1.0, 3.0], [-2.0, 0.0], [0.0, 1e-9]])[:n_input]
    X = _points(cell, 400, 0)
    assert np.all((cell[:, 0] <= X) & (cell[:, 1] >= X))
    on_face = (cell[:, 0] == X) | (cell[:, 1] == X)
    assert on_face.any(axis=1).sum() >= 100 + 2**n_input
    assert len(np.unique(X[on_face.all(axis=1)], axis=0)) == 2**n_input


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"box": [(0.0, 1.0), (1.0, 1.0)]}, "low < high"),
        ({"box": [(0.0, np.inf), (0.0, 1.0)]}, "finite"),
        ({"tolerance": 0.0}, "tolerance = 0.0: must be positive"),
        ({"rows": 0}, "rows = 0"),
        ({"max_regions": 1.5}, "max_regions = 1.5"),
        ({"function": lambda X: X}, "must give"),
        ({"function": lambda X: np.full(len(X), np.nan)}, "gives nan at"),
    ],
)
def test_bad_arguments_are_named(changes, message):
    arguments = {"function": kink, "box": [(0.0, 1.0), (0.0, 1.0)], "tolerance": 0.1, "rows": 100} | changes
    with pytest.raises(InputError, match=message):
        learn_from(arguments.pop("function"), arguments.pop("box"), **arguments)


@pytest.mark.slow
@pytest.mark.parametrize("steep", [False, True])
@pytest.mark.parametrize(("tolerance", "rows"), [(0.5, 1500), (0.15, 2000)])
def test_a_valve_map_is_learnt_to_its_tolerance(steep, tolerance, rows):
    box, estimator = [(0.0, 0.564), (0.0, 4000.0)], AbductiveRegressor(max_layers=3, output_bounds=(0.0, FLOW))
    found = learn_from(valve(steep), box, tolerance=tolerance, rows=rows, estimator=estimator)
    assert found.converged
    X = grid(box, 401)
    assert np.abs(found.model.predict(X) - valve(steep)(X)).max() <= tolerance


def test_the_search_starts_from_known_borders():
    names = [Variable("travel", "m"), Variable("load")]
    box = [(0.0, 1.0), (0.0, 1.0)]
    found = learn_from(kink, box, tolerance=0.01, edges={"travel": [0.3]}, rows=200, estimator=quick, inputs=names)
    assert found.converged
    assert [name for name in found.model.region_names()] == ["travel in (-inf, 0.3]", "travel in (0.3, inf)"]
    with pytest.raises(InputError, match="has no part in the box"):
        learn_from(kink, box, tolerance=0.01, edges={0: [1.5]}, rows=200, estimator=quick)


def test_larger_networks_take_over_when_the_search_is_over():
    def wavy(X):
        return np.sin(3.0 * X[:, 0]) * np.cos(4.0 * X[:, 1])

    box = [(-1.0, 1.0), (-1.0, 1.0)]
    small = AbductiveRegressor(max_layers=1, n_survivors=4)
    options = {"tolerance": 1e-6, "rows": 300, "estimator": small, "max_regions": 5}
    plain, finer = learn_from(wavy, box, **options), learn_from(wavy, box, **options, finer=quick, finer_rows=500)
    assert finer.largest < 0.7 * plain.largest
    assert len(finer.model.networks) == 5
    seen = np.abs(finer.model.predict(grid(box, 41)) - wavy(grid(box, 41)))
    assert seen.max() <= 1.1 * finer.largest


def test_answers_of_a_function_are_no_damaged_measurements():
    """No warning of values far from all others, as there is of tables."""

    def spike(X):
        return np.where((X[:, 0] == 1.0) & (np.abs(X[:, 1] - 0.5) < 0.01), 50.0, X[:, 0])

    assert not learn_from(spike, [(0.0, 1.0)] * 2, tolerance=1e-3, max_regions=1).converged
