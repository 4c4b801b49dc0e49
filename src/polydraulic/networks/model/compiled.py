"""A model as one compiled function, for control loops and solvers that ask for one row at a time."""

from collections.abc import Callable

import numba
import numpy as np

from polydraulic.networks.model.model import Model, pack_models
from polydraulic.networks.model.partition import choose
from polydraulic.networks.model.table import evaluate, work_size


def compiled(model: Model) -> Callable[[np.ndarray], float]:
    """Compile a model with its numbers built in.

    Parameters
    ----------
    model : Model

    Returns
    -------
    function of an (n_input,) array of float
        Gives the output, with the bits of `Model.predict`; it checks nothing. Compiling takes about a second, once.
    """
    (regions,), table = pack_models([model])
    size, n_input = work_size(table), len(model.inputs)

    @numba.njit(error_model="numpy")  # not cached: the numbers are part of the code
    def one(x: np.ndarray) -> float:
        work = np.empty(size)
        for i in range(n_input):
            work[i] = x[i]
        return evaluate(table, choose(regions, work), work)

    return one
