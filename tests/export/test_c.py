"""Generated C, compiled strictly and run: the same bits as the package."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.export import c_name, export_c, to_c
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks import AbductiveRegressor, Model, PerceptronRegressor, RegionRegressor, Variable

FLAGS = "-std=c99 -O2 -Wall -Wextra -Werror -Wconversion -Wdouble-promotion -Wshadow -pedantic".split()
RNG = np.random.default_rng(9)
X = RNG.uniform(-1.0, 1.0, size=(400, 3))
Y = np.exp(X[:, 0]) * np.cos(3.0 * X[:, 1]) + np.abs(X[:, 2])

MODELS = {
    "single network": lambda: AbductiveRegressor(max_layers=3).fit(X, Y).to_model(output=Variable("y")),
    "with a linear node": lambda: (
        AbductiveRegressor(kinds=("single", "linear")).fit(X, Y).to_model(output=Variable("lin"))
    ),
    "regions": lambda: (
        RegionRegressor(AbductiveRegressor(max_layers=2, output_bounds=(-1.0, 2.0)), edges={2: [0.0], 0: [-0.3, 0.4]})
        .fit(X, Y)
        .to_model([Variable("a", "m"), Variable("b"), Variable("c")], Variable("out put", "Pa"))
    ),
    "constant": lambda: AbductiveRegressor().fit(X, np.full(400, -2.5)).to_model(output=Variable("int")),
    "perceptron": lambda: (
        PerceptronRegressor(hidden_units=3, max_iter=20, n_starts=1).fit(X, Y).to_model(output=Variable("mlp"))
    ),
    "shipped input flow": lambda: shipped_models()[3],
    "shipped output flow": lambda: shipped_models()[1],
}


def compiled(model: Model, folder, compiler="gcc"):
    name = c_name(model.output.name)
    source = next(path for path in export_c([model], folder) if path.suffix == ".c")
    library = folder / f"{name}.so"
    subprocess.run([compiler, *FLAGS, "-shared", "-fPIC", str(source), "-o", str(library)], check=True)
    function = getattr(ctypes.CDLL(str(library)), name)
    function.restype = ctypes.c_double
    return function


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
@pytest.mark.parametrize("which", MODELS)
def test_c_equals_the_package_bit_for_bit(which, tmp_path):
    model = MODELS[which]()
    function = compiled(model, tmp_path)
    low, high = model.domain().T
    width = np.where(high > low, high - low, 1.0)
    points = low - 0.2 * width + 1.4 * width * RNG.uniform(size=(500, len(low)))  # inside and outside the domain
    corners = np.array(np.meshgrid(*model.domain())).reshape(len(low), -1).T
    on_edges = points[:20].copy()
    border = model.region_boxes()[0][:, 1]
    on_edges[:, np.isfinite(border)] = border[np.isfinite(border)]
    points = np.vstack([points, corners, on_edges])
    found = [function((ctypes.c_double * len(low))(*row)) for row in points]
    assert np.array_equal(np.array(found), model.predict(points))


def test_names_units_and_domain_are_in_the_comments():
    header, source = to_c(MODELS["regions"](), name="f")
    assert " * f: out put [Pa] from" in header
    assert " *   x[0]  a [m], domain (" in header or " *   x[0]  a [m], domain -" in header
    assert "/* a in (-0.3, 0.4] and c in (0, inf) */" in source
    assert "malloc" not in source
    assert "#include <" not in source


@pytest.mark.parametrize(
    ("name", "expected"), [("boom.q_in", "boom_q_in"), ("int", "int_"), ("3d", "m_3d"), ("Öl", "m__l"), ("_x", "m__x")]
)
def test_c_names(name, expected):
    assert c_name(name) == expected


def test_outputs_must_give_different_names(tmp_path):
    model = MODELS["single network"]()
    other = Model(model.inputs, Variable("y "), model.networks, model.partition)
    clash = Model(model.inputs, Variable("y_"), model.networks, model.partition)
    with pytest.raises(InputError, match="they must differ"):
        export_c([other, clash], tmp_path)
    assert list(tmp_path.iterdir()) == []
