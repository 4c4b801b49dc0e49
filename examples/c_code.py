"""Export a network as C99, compile it, call it: the same bits as in Python. Needs a C compiler."""

import ctypes
import subprocess

import numpy as np

from polydraulic import AbductiveRegressor
from polydraulic.export import export_c
from polydraulic.networks import Variable

X = np.random.default_rng(0).uniform(-1.0, 1.0, size=(500, 2))
learner = AbductiveRegressor().fit(X, X[:, 0] * X[:, 1] + 0.3 * X[:, 0] ** 3)
model = learner.to_model([Variable("a"), Variable("b")], Variable("mixed"))
export_c([model], "c")
subprocess.run("gcc -std=c99 -O2 -shared -fPIC c/mixed.c -o mixed.so".split(), check=True)

mixed = ctypes.CDLL("./mixed.so").mixed
row, answer = (ctypes.c_double * 2)(), (ctypes.c_double * 1)()


def from_c(point):
    """One answer of the C function, which also says whether the point lies in the domain."""
    row[:] = point
    mixed(row, answer)
    return answer[0]


points = np.random.default_rng(1).uniform(-1.5, 1.5, size=(1000, 2))  # beyond the training data, too
answers = [from_c(point) for point in points]
print(f"{len(points)} answers of C, the first {answers[0]:.6f}")
assert np.array_equal(answers, model.predict(points))  # equal to the last bit
