"""Accuracy and speed of abductive networks next to other learners, in one run, as ratios.

``python benchmarks/networks.py [--peers] [--data FOLDER] [--quick]``. `--peers` adds GMDH, MARS and symbolic regression from an
environment of their own (`make bench-peers`), `--data` every CSV file of a folder, last column the target; `--quick` takes
fewer rows, `--only` some parts of it. One thread throughout. It asserts that the exported C gives the bits of `Model.predict`, and nothing else.
"""

import argparse
import ctypes
import resource
import subprocess
import tempfile
import warnings
from functools import partial
from pathlib import Path
from shutil import which

import numpy as np
from sklearn.datasets import make_friedman1
from threadpoolctl import threadpool_limits

from accuracy import OURS, accuracy, cubic_ridge
from data_sets import all_sets
from polydraulic import AbductiveRegressor
from polydraulic.export import export_c
from polydraulic.export.formula import to_python
from polydraulic.networks import PerceptronRegressor, Variable
from polydraulic.networks.growth.moments import _parts, moments
from polydraulic.networks.growth.scoring import squared_errors
from polydraulic.networks.model.compiled import compiled
from polydraulic.networks.model.nodes import DOUBLE, TRIPLE, design
from polydraulic.thesis.timing import paired_ratio, paired_times, timed
from show import left_out, show

FLOPS = 53  # a row and Triple: what rates are counted in, whatever it takes to find its moments


def scoring(n_row, n=60, sample=12, side=1500):
    rng = np.random.default_rng(0)
    v, t, a = rng.normal(size=(n_row, n)), rng.normal(size=n_row), rng.normal(size=(side, side))
    doubles = np.array([(i, j) for i in range(n) for j in range(i)])
    triples = np.array([(i, j, k) for i in range(n) for j in range(i) for k in range(j)])

    def scored():
        m = moments(v, t)
        return squared_errors(m, DOUBLE, doubles), squared_errors(m, TRIPLE, triples)

    def one_by_one():
        return [np.linalg.lstsq(design(TRIPLE, v[:, i]), t) for i in triples[:: len(triples) // sample][:sample]]

    count = len(doubles) + len(triples)
    share = FLOPS * n_row * len(triples) / (2.0 * side**3)  # useful operations of a scoring over those of a product
    useful, alone = (paired_ratio(lambda: a @ a, call, pairs=7) for call in (scored, lambda: moments(v, t)))
    entries = sum(part.pair.size + part.square.size for part in _parts(n, 0)) + (4 * n + 2) ** 2 / 2 + n * n
    done = 2.0 * entries / (FLOPS * len(triples))  # by BLAS, over what is counted
    lstsq = paired_ratio(one_by_one, scored, pairs=7)
    print(f"\nscoring {count} candidates, {n} inputs, {n_row} rows; ratios with quartiles of 7 pairs")
    print(
        f"  useful operations, as a share of the DGEMM rate: {useful.times(share)}; moments alone: {alone.times(share)}"
    )
    print(f"  operations done, {FLOPS * done:.1f} a row and Triple, as a share of it: {alone.times(share * done)}")
    print(f"  a candidate by numpy's lstsq ({sample} tried), in times of scoring: {lstsq.times(count / sample)}")


def fitting(quick):
    X, y = make_friedman1(1000, 10, noise=1.0, random_state=0)
    learners = {
        "cubic ridge": cubic_ridge(),
        OURS: AbductiveRegressor(),
        f"{OURS}, refine=False": AbductiveRegressor(refine=False),
    }
    calls = {name: (lambda model=model: model.fit(X, y)) for name, model in learners.items()}
    show("fitting friedman1, 1000 rows, 10 inputs", paired_times(calls, pairs=11), "ms")
    if quick:
        return
    rng = np.random.default_rng(0)
    X = rng.uniform(size=(1_000_000, 10))
    y = 10 * np.sin(np.pi * X[:, 0] * X[:, 1]) + 20 * (X[:, 2] - 0.5) ** 2 + 10 * X[:, 3] + 5 * X[:, 4]
    y += rng.normal(size=len(y))
    print("\nfitting friedman1, 1e6 rows, 10 inputs")
    for refined in (False, True):
        model, seconds = timed(lambda refined=refined: AbductiveRegressor(refine=refined).fit(X, y))
        print(f"  refine={refined!s:5s} {seconds:8.1f} s of processor time,", end=" ")
        print(f"{model.network_.n_coefficients} coefficients, mean squared error {model.fse_:.4f}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"  largest memory of this process so far, all benchmarks and the rows included: {peak:.2f} GiB")


STRICT = "-std=c99 -ffp-contract=off -fno-semantic-interposition -shared -fPIC".split()
SIMD = "-O3 -march=native -fno-trapping-math -fno-tree-pre".split()
# Rows one after another through the exported function, which also says whether they lie in the domain; and columns through the
# network alone, of which gcc makes vector instructions.
LOOPS = """#include "{name}.c"

int rows(const double *restrict x, long n, double *restrict y)
{{
    int status = 0;
    for (long i = 0; i < n; i++)
        status |= {name}(x + {n} * i, y + i);
    return status;
}}

__attribute__((flatten)) int columns(const double *restrict x, long n, double *restrict y)
{{
    for (long i = 0; i < n; i++) {{
        const double one[{n}] = {{{columns}}};
        y[i] = value_0_0(one);
    }}
    return 0;
}}
"""


def in_c(model, rows, folder):
    """Calls of the exported C over all rows, each of which returns a new array, as `Model.predict` does."""
    (name,) = (path.stem for path in export_c([model], folder) if path.suffix == ".c")
    assert len(model.networks) == 1  # value_0_0 is all of it
    n, columns = len(model.inputs), np.ascontiguousarray(rows.T)
    text = LOOPS.format(name=name, n=n, columns=", ".join(f"x[i + {i} * n]" for i in range(n)))
    (Path(folder) / "loops.c").write_text(text)
    calls = {}
    for label, entry, x, flags in (
        ("C, exported function, gcc -O2", "rows", rows, ["-O2"]),
        ("C, network in vectors, gcc -O3", "columns", columns, SIMD),
    ):
        library = Path(folder) / f"{entry}.so"
        subprocess.run(["gcc", *flags, *STRICT, "loops.c", "-o", library, "-lm"], check=True, cwd=folder)
        calls[label] = partial(into_new_array, getattr(ctypes.CDLL(str(library)), entry), x, len(rows))
    return calls


def into_new_array(function, x, n):
    y = np.empty(n)
    function(ctypes.c_void_p(x.ctypes.data), ctypes.c_long(n), ctypes.c_void_p(y.ctypes.data))
    return y


def evaluation(n_row=20_000):
    X, y = make_friedman1(1000, 5, random_state=0)
    models = {
        "network": AbductiveRegressor().fit(X, y).to_model(output=Variable("network")),
        "perceptron": PerceptronRegressor(n_starts=1).fit(X, y).to_model(output=Variable("perceptron")),
    }
    rows = np.random.default_rng(0).uniform(size=(n_row, 5))
    if which("gcc") is None:
        left_out("exported C, next to Model.predict", "install gcc")
    for model in models.values():
        with tempfile.TemporaryDirectory() as folder:
            peers = in_c(model, rows, folder) if which("gcc") else {}
            calls = {"Model.predict": lambda model=model: model.predict(rows)}
        for label, call in peers.items():
            assert np.array_equal(call(), model.predict(rows)), f"{model.output}: {label} and Model.predict differ"
        times = paired_times(calls | peers, pairs=201)
        title = f"{model.output}: {len(model.networks[0].nodes)} nodes, {model.n_coefficients} coefficients"
        show(f"{title}, {n_row} rows, bits equal: each row", times, "ns", per=n_row)
    one_row(models["network"], AbductiveRegressor().fit(X, y), rows[:1].copy())


def one_row(model, learner, one, times=200):
    place = {}
    exec(to_python(model, "formula"), place)
    function, values, single = compiled(model), one[0].tolist(), one[0]
    calls = {
        "Model.predict": lambda: [model.predict(one) for _ in range(times)],
        "AbductiveRegressor.predict": lambda: [learner.predict(one) for _ in range(times)],
        "compiled(model)": lambda: [function(single) for _ in range(times)],
        "source of to_python": lambda: [place["formula"](*values) for _ in range(times)],
    }
    show("one row, asked from Python", paired_times(calls), "us", per=times)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", help="folder of CSV files; the last column is the target")
    parser.add_argument("--peers", action="store_true", help="also the learners of .venv-peers")
    parser.add_argument("--quick", action="store_true", help="fewer rows")
    parser.add_argument(
        "--only", nargs="+", choices=["accuracy", "scoring", "fitting", "evaluation"], help="parts of it"
    )
    options = parser.parse_args()

    def wanted(part):
        return options.only is None or part in options.only

    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")  # what others say about convergence and conditioning
        if wanted("accuracy"):
            if not options.peers:
                left_out(
                    "GMDH, MARS and symbolic regression, next to AbductiveRegressor",
                    "make bench-peers sets them up and runs all of this",
                )
            accuracy(all_sets(300 if options.quick else 1000, options.data), options.peers)
        if wanted("scoring"):
            scoring(10_000 if options.quick else 100_000)
        if wanted("fitting"):
            fitting(options.quick)
        if wanted("evaluation"):
            evaluation()


if __name__ == "__main__":
    main()
