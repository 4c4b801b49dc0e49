import numpy as np
import pytest

from polydraulic.simulation.solvers.small_system import factorise_system, solve_system


@pytest.mark.parametrize("first", [0, 4])
def test_solutions_are_those_of_a_dense_solver(first):
    """With diagonal elements as pivots of the first unknowns; of the others some are zero."""
    rng = np.random.default_rng(first)
    for _ in range(50):
        matrix = rng.normal(size=(9, 9)) * (rng.uniform(size=(9, 9)) < 0.5)
        matrix[range(first), range(first)] = 5.0 + rng.uniform(size=first)
        if abs(np.linalg.det(matrix)) < 1e-2:
            continue
        factors, order, right = matrix.copy(), np.empty(9, dtype=np.int64), rng.normal(size=9)
        factorise_system(factors, order, first, 9)
        assert list(order[:first]) == list(range(first))
        found = right.copy()
        solve_system(factors, order, found, first, 9)
        assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-7, abs=1e-9)


def test_a_zero_on_the_diagonal_is_exchanged():
    matrix, order, right = np.array([[0.0, 2.0], [3.0, 1.0]]), np.empty(2, dtype=np.int64), np.array([4.0, 8.0])
    factorise_system(matrix, order, 0, 2)
    solve_system(matrix, order, right, 0, 2)
    assert list(order) == [1, 1]
    assert list(right) == [2.0, 2.0]
