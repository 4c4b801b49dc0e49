"""Speed and size of exported C next to the same network written by hand.

``python benchmarks/exports.py`` needs gcc; it prints and asserts nothing. The network is that of Fig 3-1. By hand means:
normalize, nodes with their terms nested, unitize, and nothing else: no borders, no flags.
"""

import ctypes
import subprocess
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from polydraulic import load_machine
from polydraulic.export import bundle, to_c
from polydraulic.export.c.network import polynomial
from polydraulic.networks import Variable
from polydraulic.thesis.single_link import fit_full_box

N, REPEATS, TURNS = 1000, 2000, 15
FLAGS = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror"]

TIMER = """#include <time.h>
#include "net.h"
double by_hand(const double x[]);
int mine(const double x[], double y[1]);
typedef int f(const double *, double *);
static int hand(const double x[], double y[]) { y[0] = by_hand(x); return 0; }
static int own_slopes(const double x[], double y[]) { double dy[NET_N_INPUTS]; return net_slopes(x, y, dy) + (dy[0] > 1e300); }
static f *const all[3] = {hand, net, own_slopes};
double seconds(int which, const double *x, int n, int repeats, double *sum)
{
    f *const volatile one = all[which];
    const clock_t start = clock();
    int i, r;
    for (r = 0; r < repeats; ++r)
        for (i = 0; i < n; ++i) {
            double y[1];
            one(x + NET_N_INPUTS * i, y);
            *sum += y[0];
        }
    return (double)(clock() - start) / CLOCKS_PER_SEC;
}
"""


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
        (folder / "timer.c").write_text(TIMER)
        flags = ["-shared", "-fPIC", "net.c", "hand.c", "timer.c", "-o", "all.so"]
        subprocess.run(["gcc", *FLAGS, *flags], cwd=folder, check=True)
        library = ctypes.CDLL(str(folder / "all.so"))
        library.seconds.restype = ctypes.c_double
        where, total = X.ctypes.data_as(ctypes.c_void_p), ctypes.c_double()
        found = {0: [], 1: [], 2: []}
        for _ in range(TURNS):
            for which, seconds in found.items():
                seconds.append(library.seconds(which, where, N, REPEATS, ctypes.byref(total)))
        hand = median(found[0])
        print(f"{len(model.networks[0].nodes)} nodes, {model.n_coefficients} coefficients")
        for name, seconds in zip(
            ("by hand", "exported: output and flag", "exported: with slopes"), found.values(), strict=True
        ):
            print(f"  {name:28s} {median(seconds) / N / REPEATS * 1e9:7.2f} ns   ratio {median(seconds) / hand:5.2f}")


if __name__ == "__main__":
    main()
