"""Accuracy and speed of abductive networks next to other learners, in one run, as ratios.

``python benchmarks/networks.py [--peers] [--data FOLDER] [--quick]``: it prints and asserts nothing. `--peers` adds GMDH, MARS
and symbolic regression from an environment of their own (`make bench-peers`), `--data` every CSV file of a folder, last column
the target; `--quick` takes fewer rows. One thread throughout.
"""

import argparse
import ctypes
import re
import resource
import subprocess
import tempfile
import warnings
from shutil import which
from time import perf_counter, process_time

import numpy as np
from sklearn.datasets import make_friedman1
from threadpoolctl import threadpool_limits

from accuracy import OURS, accuracy, cubic_ridge
from data_sets import all_sets
from polydraulic import AbductiveRegressor
from polydraulic.export import c_name, export_c
from polydraulic.export.formula import to_python
from polydraulic.networks import PerceptronRegressor, Variable
from polydraulic.networks.growth.moments import moments
from polydraulic.networks.growth.scoring import squared_errors
from polydraulic.networks.model.compiled import compiled
from polydraulic.networks.model.nodes import DOUBLE, TRIPLE, design
from run import in_turn, show

FLOPS = 53  # useful operations a row and Triple: its moments that no pair of variables has


def dgemm_rate(n=1500):
    """Operations a second of a matrix product."""
    a = np.random.default_rng(0).normal(size=(n, n))
    return 2.0 * n**3 / in_turn({"product": lambda: a @ a}, 3)["product"]


def scoring(n_row, n=60, sample=12):
    rng = np.random.default_rng(0)
    v, t = rng.normal(size=(n_row, n)), rng.normal(size=n_row)
    doubles = np.array([(i, j) for i in range(n) for j in range(i)])
    triples = np.array([(i, j, k) for i in range(n) for j in range(i) for k in range(j)])
    squared_errors(moments(v[:99, :4], t[:99]), TRIPLE, triples[:1])

    start = perf_counter()
    m = moments(v, t)
    middle = perf_counter()
    squared_errors(m, DOUBLE, doubles)
    squared_errors(m, TRIPLE, triples)
    end = perf_counter()
    rate, count = dgemm_rate(), len(doubles) + len(triples)
    again = perf_counter()
    for inputs in triples[:: len(triples) // sample][:sample]:
        np.linalg.lstsq(design(TRIPLE, v[:, inputs]), t)
    one = (perf_counter() - again) / sample
    share = FLOPS * n_row * len(triples) / (end - start) / rate
    print(f"\nscoring {count} candidates, {n} inputs, {n_row} rows")
    print(
        f"  moments {middle - start:.3f} s, small solutions {end - middle:.3f} s: {count / (end - start):.0f} candidates/s"
    )
    print(f"  useful operations {share:.1%} of DGEMM at {rate / 1e9:.1f} Gflop/s; moments alone", end=" ")
    print(f"{FLOPS * n_row * len(triples) / (middle - start) / rate:.1%}")
    print(f"  numpy lstsq, {sample} candidates one by one: {1 / one:.1f}/s, ratio {count / (end - start) * one:.0f}")


def fitting(quick):
    X, y = make_friedman1(1000, 10, noise=1.0, random_state=0)
    learners = {
        "cubic ridge": cubic_ridge(),
        OURS: AbductiveRegressor(),
        f"{OURS}, refine=False": AbductiveRegressor(refine=False),
    }
    calls = {name: (lambda model=model: model.fit(X, y)) for name, model in learners.items()}
    show("fitting friedman1, 1000 rows, 10 inputs", in_turn(calls, 3), "ms", 1e3)
    if quick:
        return
    rng = np.random.default_rng(0)
    X = rng.uniform(size=(1_000_000, 10))
    y = 10 * np.sin(np.pi * X[:, 0] * X[:, 1]) + 20 * (X[:, 2] - 0.5) ** 2 + 10 * X[:, 3] + 5 * X[:, 4]
    y += rng.normal(size=len(y))
    print("\nfitting friedman1, 1e6 rows, 10 inputs")
    for refined in (False, True):
        start, busy = perf_counter(), process_time()
        model = AbductiveRegressor(refine=refined).fit(X, y)
        elapsed, busy = perf_counter() - start, process_time() - busy
        print(f"  refine={refined!s:5s} {elapsed:8.1f} s, {busy:6.1f} s of processor time,", end=" ")
        print(f"{model.network_.n_coefficients} coefficients, mean squared error {model.fse_:.4f}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"  largest memory of this process so far, all benchmarks and the rows included: {peak:.2f} GiB")


STRICT = "-ffp-contract=off -fno-semantic-interposition -shared -fPIC".split()
SIMD = "-O3 -march=native -fno-trapping-math -fno-tree-pre".split()


def c_rows(model, folder, flags):
    """The exported C function in a loop over rows, written in C; or None without gcc.

    With the flags of SIMD gcc makes vector instructions of it, once each input is an argument and a column of its own.
    """
    if which("gcc") is None:
        print("\nC is left out: there is no gcc")
        return None
    name, n = c_name(model.output.name), len(model.inputs)
    source = next(path for path in export_c([model], folder) if path.suffix == ".c")
    text = source.read_text().replace(f'#include "{name}.h"', "")
    names = [f"x{i}" for i in range(n)]
    text = re.sub(r"const double x\[\d+\]", ", ".join(f"const double {x}" for x in names), text)
    text = re.sub(r"\bx\[(\d+)\]", r"x\1", text).replace("(x)", f"({', '.join(names)})")
    values = ", ".join(f"x[i + {i} * n]" for i in range(n))
    text += (
        "__attribute__((flatten)) void rows(const double *restrict x, long n, double *restrict y)\n"
        f"{{ for (long i = 0; i < n; i++) y[i] = {name}({values}); }}\n"
    )
    source.write_text(text)
    library = source.with_suffix(f".{flags[0][1:]}.so")
    subprocess.run(["gcc", *flags, *STRICT, str(source), "-o", str(library), "-lm"], check=True)
    pointer = ctypes.POINTER(ctypes.c_double)
    function = ctypes.CDLL(str(library)).rows
    function.argtypes = [pointer, ctypes.c_long, pointer]
    return lambda columns, y: function(columns.ctypes.data_as(pointer), len(y), y.ctypes.data_as(pointer))


def evaluation(n_row=20_000):
    X, y = make_friedman1(1000, 5, random_state=0)
    models = {
        "network": AbductiveRegressor().fit(X, y).to_model(output=Variable("network")),
        "perceptron": PerceptronRegressor(n_starts=1).fit(X, y).to_model(output=Variable("perceptron")),
    }
    rows = np.random.default_rng(0).uniform(size=(n_row, 5))
    columns = np.ascontiguousarray(rows.T)
    for model in models.values():
        out = np.empty(n_row)
        calls = {"Model.predict": lambda model=model: model.predict(rows)}
        with tempfile.TemporaryDirectory() as folder:
            for flags in (SIMD, ["-O2"]):
                in_c = c_rows(model, folder, flags)
                if in_c is not None:
                    calls[f"C, gcc {' '.join(flags[:2])}"] = lambda in_c=in_c, out=out: in_c(columns, out)
            title = f"{model.output}: {len(model.networks[0].nodes)} nodes, {model.n_coefficients} coefficients"
            show(f"{title}, {n_row} rows: each", in_turn(calls, 21), "ns", 1e9 / n_row)
    model, learner, one = models["network"], AbductiveRegressor().fit(X, y), rows[:1].copy()
    place = {}
    exec(to_python(model, "formula"), place)
    function, values, single = compiled(model), one[0].tolist(), one[0]
    repeated = {
        "Model.predict": lambda: [model.predict(one) for _ in range(200)],
        "AbductiveRegressor.predict": lambda: [learner.predict(one) for _ in range(200)],
        "compiled(model)": lambda: [function(single) for _ in range(200)],
        "source of to_python": lambda: [place["formula"](*values) for _ in range(200)],
    }
    show("one row, asked from Python", in_turn(repeated), "us", 1e6 / 200)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", help="folder of CSV files; the last column is the target")
    parser.add_argument("--peers", action="store_true", help="also the learners of .venv-peers")
    parser.add_argument("--quick", action="store_true", help="fewer rows")
    options = parser.parse_args()
    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")  # what others say about convergence and conditioning
        accuracy(all_sets(300 if options.quick else 1000, options.data), options.peers)
        scoring(10_000 if options.quick else 100_000)
        fitting(options.quick)
        evaluation()


if __name__ == "__main__":
    main()
