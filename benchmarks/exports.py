"""Speed and size of exported C next to the same network written by hand.

``python benchmarks/exports.py`` needs gcc. The network is that of Fig 3-1. By hand means: normalize, nodes with their terms
nested, unitize, and nothing else: no borders, no flags. It asserts that all of them give what `Model.predict` gives.
"""

import ctypes
import subprocess
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

import numpy as np

from polydraulic import load_machine
from polydraulic.export import bundle, to_c
from polydraulic.export.c.network import polynomial
from polydraulic.networks import Variable
from polydraulic.networks.model.slopes import model_slopes
from polydraulic.thesis.single_link import fit_full_box
from polydraulic.thesis.timing import paired_times
from show import left_out, show

N, REPEATS = 1000, 200
FLAGS = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror"]

# Points through one function, chosen at run time; everything that it gives goes into the sum.
LOOP = """#include "net.h"
double by_hand(const double x[]);
static int hand(const double x[], double y[]) { y[0] = by_hand(x); return 0; }
static int slopes(const double x[], double y[])
{
    double dy[NET_N_INPUTS];
    const int status = net_slopes(x, y, dy);
    int i;
    for (i = 0; i < NET_N_INPUTS; ++i)
        y[0] += dy[i];
    return status;
}
typedef int f(const double *, double *);
static f *const all[3] = {hand, net, slopes};
double sum(int which, const double *x, int n, int repeats)
{
    f *const volatile one = all[which];
    double total = 0.0;
    int i, r;
    for (r = 0; r < repeats; ++r)
        for (i = 0; i < n; ++i) {
            double y[1];
            total += one(x + NET_N_INPUTS * i, y);
            total += y[0];
        }
    return total;
}
"""
LABELS = ("by hand", "exported: output and flag", "exported: with slopes")


def by_hand(network):
    names = [f"n{i}" for i in range(network.n_inputs)] + [f"z{k}" for k in range(len(network.nodes))]
    lines = [
        f"const double n{i} = (x[{i}] - {network.x_mean[i]!r}) * {1.0 / network.x_scale[i]!r};"
        for i in range(network.n_inputs)
    ]
    lines += [f"const double z{k} = {polynomial(node, names)};" for k, node in enumerate(network.nodes)]
    lines.append(f"return {network.y_mean!r} + {network.y_scale!r} * {names[-1]};")
    return "double by_hand(const double x[])\n{\n" + "\n".join(lines) + "\n}\n"


def main():
    if which("gcc") is None:
        left_out("exported C next to C by hand", "install gcc")
        return
    fitted = fit_full_box(load_machine("cat215b"))
    model = fitted.estimator.to_model(fitted.inputs, Variable("net", "in3/s"))
    whole = bundle([model], name="net")
    X = whole.points(3 * N)[:N]  # inside
    with TemporaryDirectory() as place:
        folder = Path(place)
        for real in ("float", "double"):
            (folder / "net.h").write_text(to_c(whole, real=real)[0])
            (folder / "net.c").write_text(to_c(whole, real=real)[1])
            subprocess.run(["gcc", *FLAGS, "-c", "net.c"], cwd=folder, check=True)
            parts = subprocess.run(["size", "net.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
            code, data = parts.splitlines()[1].split()[:2]
            source = (folder / "net.c").stat().st_size
            print(f"{real}: {source} bytes of C, compiled {code} bytes of code and constants, {data} of data")
        (folder / "hand.c").write_text(by_hand(model.networks[0]))
        (folder / "loop.c").write_text(LOOP)
        flags = ["-shared", "-fPIC", "net.c", "hand.c", "loop.c", "-o", "all.so"]
        subprocess.run(["gcc", *FLAGS, *flags], cwd=folder, check=True)
        total = ctypes.CDLL(str(folder / "all.so")).sum
        total.restype = ctypes.c_double
        where = X.ctypes.data_as(ctypes.c_void_p)
        y, dy = model.predict(X), model_slopes(model, X)
        for which_one, expected in enumerate((y.sum(), y.sum(), y.sum() + dy.sum())):
            assert np.isclose(total(which_one, where, N, 1), expected, rtol=1e-9), LABELS[which_one]
        calls = {name: lambda k=k: total(k, where, N, REPEATS) for k, name in enumerate(LABELS)}
        title = f"{len(model.networks[0].nodes)} nodes, {model.n_coefficients} coefficients: a point"
        show(title, paired_times(calls), "ns", per=N * REPEATS)


if __name__ == "__main__":
    main()
