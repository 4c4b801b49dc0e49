"""Dynamic models on public logs: learn the first half, run on their own through the second half.

    python benchmarks/dynamic.py --data FOLDER

FOLDER holds ``hydraulic_actuator/actuator.mat`` (Sjoberg 1995: valve position u in row 0 of ``X``, oil pressure y) and
``wheel_loader/wheel_loader.csv.gz`` (joysticks, engine, forces and speeds of a wheel loader, about 20 rows a second); one may be
missing. Nothing is chosen on the second half. Errors are root mean squares; *of std* means divided by the standard deviation in
the rows that judge, so that 1 is what their mean would reach. Then two questions of where it does not pay: quarters of the actuator's first half, each run by a
model of the other three, and a system of two filters with a saturation between them. Seconds are of processor time, of all threads.
"""

import argparse
import gzip
import warnings
from functools import partial
from pathlib import Path
from time import process_time

import numpy as np
from scipy.io import loadmat
from sklearn.linear_model import LinearRegression
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits

from polydraulic import AbductiveRegressor
from polydraulic.networks import DynamicRegressor
from polydraulic.networks.dynamic.spans import lagged
from polydraulic.thesis.timing import timed
from show import left_out

timed = partial(timed, clock=process_time)  # a fit works in several threads

SEEDS = range(5)
SECOND = 20  # rows of the wheel loader's log in a second, from its angles and speeds
INPUTS = ("lift_joystick", "tilt_joystick", "throttle", "engine_speed_rps")
OUTPUTS = ("force_lift_MN", "boom_speed_deg_per_sec")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", required=True, type=Path, help="folder with the public logs")
    options = parser.parse_args()
    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")  # what others say about convergence
        for file, show in (
            ("hydraulic_actuator/actuator.mat", actuator),
            ("wheel_loader/wheel_loader.csv.gz", wheel_loader),
        ):
            path = options.data / file
            show(path) if path.is_file() else left_out(file, f"put it into {options.data}")
        deep_system()


def actuator(path):
    data = loadmat(path)
    u, y = data["X"][0][:, None], data["y"][0][:, None]
    print(
        f"\n### Hydraulic actuator: rms error of the oil pressure, 512 rows free run, standard deviation {y[512:].std():.2f}\n"
    )
    print("| model | free run | one step | seconds of fit |\n|---|---|---|---|")
    found = {}
    for name, errors, seconds in compared(u, y, 512, (None, 1)):
        print(f"| {name} | {errors[0][0]:.3f} | {errors[1][0]:.3f} | {seconds:.1f} |", flush=True)
        found[name] = np.array(errors[0])
    print_share(found)
    print("\n### Hydraulic actuator: quarters of the first 512 rows, each run by a model of the others\n")
    print("| rows | standard deviation | error, of std |\n|---|---|---|")
    for first in range(0, 512, 128):
        quarter, rest = slice(first, first + 128), y[:512, 0].copy()
        rest[quarter] = np.nan
        model = DynamicRegressor().fit(u[:512], rest)
        begin = max(first - model.warm_up_, 0)
        run = model.simulate(u[begin : first + 128], y[begin : first + 128, 0])
        at = slice(begin + model.warm_up_, first + 128)
        error, spread = rms(run[model.warm_up_ :] - y[at, 0]), y[at, 0].std()
        print(f"| {first} to {first + 128} | {spread:.2f} | {error / spread:.2f} |", flush=True)


def wheel_loader(path):
    with gzip.open(path, "rt") as text:
        log = np.genfromtxt(text, delimiter=",", names=True)
    X, y = (np.column_stack([log[name] for name in names]) for names in (INPUTS, OUTPUTS))
    half = len(y) // 2
    spread = y[half:].std(axis=0)
    print(f"\n### Wheel loader: rms error of std, lift force / boom speed, {len(y) - half} rows\n")
    print("| model | free run | begun anew every second | one step | seconds of fit |\n|---|---|---|---|---|")
    found = {}
    for name, errors, seconds in compared(X, y, half, (None, SECOND, 1)):
        cells = [" / ".join(f"{value:.3f}" for value in error / spread) for error in errors]
        print(f"| {name} | {' | '.join(cells)} | {seconds:.1f} |", flush=True)
        found[name] = errors[0]
    print_share(found)


def print_share(found):
    """Free runs next to the better linear model of each output."""
    linear = np.min([errors for name, errors in found.items() if name.startswith("linear")], axis=0)
    (own,) = (errors for name, errors in found.items() if name.startswith("DynamicRegressor"))
    print(f"\nDynamicRegressor, of the better linear model: {' / '.join(f'{value:.0%}' for value in own / linear)}")


def deep_system():
    """A filter, a saturation and another filter: one polynomial, and networks of several layers that are refined."""
    print("\n### A filter, a saturation and another filter: rms error of 1000 rows free run\n")
    print("| rows learnt | seed | DynamicRegressor() | of AbductiveRegressor(max_layers=3) | the second of the first |")
    print("|---|---|---|---|---|")
    for n in (600, 1200, 2400):
        rows = []
        for seed in SEEDS:
            u, y, clean = filtered(n + 1000, seed)
            errors = []
            for model in (DynamicRegressor(), DynamicRegressor(AbductiveRegressor(max_layers=3))):
                model.fit(u[:n], y[:n])
                first = n - model.warm_up_
                errors.append(rms(model.simulate(u[first:], y[first:])[model.warm_up_ :] - clean[n:]))
            rows.append([*errors, errors[1] / errors[0]])
            print(f"| {n} | {seed} | {' | '.join(shown(rows[-1]))} |", flush=True)
        print(f"| {n} | median | {' | '.join(shown(np.median(rows, axis=0)))} |", flush=True)


def shown(row):
    return f"{row[0]:.4f}", f"{row[1]:.4f}", f"{row[2]:.2f}"


def filtered(n, seed):
    """Input (n, 1), output with noise, and output without."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.uniform(-2.0, 2.0, size=n // 10 + 1), 10)[:n]
    first, clean = 0.0, np.zeros(n)
    for t in range(1, n):
        first = 0.8 * first + 0.2 * u[t - 1]
        clean[t] = 0.9 * clean[t - 1] + 0.1 * np.tanh(2.0 * first)
    return u[:, None], clean + rng.normal(0.0, 0.01, n), clean


def compared(X, y, half, horizons):
    """Yield each model's name, rms errors by horizon and output, and seconds of fit."""
    yield "last value held", [held(y, half, horizon) for horizon in horizons], 0.0
    others = {
        "linear ARX(3, 3), no constant": [LinearRegression(fit_intercept=False)],
        "linear ARX(3, 3)": [LinearRegression()],
        f"MLP of 20 hidden units (3, 3), median of {len(SEEDS)} seeds": [perceptron(seed) for seed in SEEDS],
    }
    for name, learners in others.items():
        found = [lagged_errors(learner, X, y, half, horizons) for learner in learners]
        yield name, np.median([errors for errors, _ in found], axis=0), np.mean([seconds for _, seconds in found])
    for name, settings in {
        "network (3, 3) of two layers, grown one step ahead": {
            "estimator": AbductiveRegressor(max_layers=2), "input_lags": (1, 2, 3), "output_lags": (1, 2, 3),
            "increments": True, "horizon": None,
        },
        "DynamicRegressor, all chosen by held-out runs": {},
    }.items():  # fmt: skip
        model, seconds = timed(lambda settings=settings: DynamicRegressor(**settings).fit(X[:half], y[:half]))
        first = half - model.warm_up_
        found = [model.simulate(X[first:], y[first:], horizon=horizon)[model.warm_up_ :] for horizon in horizons]
        chosen = model.choice_
        if not settings:
            name += f": lags on offer {chosen.input_lags}, horizon {chosen.horizon}, {chosen.terms} terms, "
            name += f"K {sum(one.n_coefficients for one in model.models_)}"
        yield name, [rms(values - y[half:]) for values in found], seconds


def perceptron(seed):
    return make_pipeline(StandardScaler(), MLPRegressor(hidden_layer_sizes=(20,), solver="lbfgs", alpha=1e-3, max_iter=2000, random_state=seed))  # fmt: skip


def lagged_errors(learner, X, y, half, horizons):
    """Fit on lags 1 to 3 of everything, then run in windows of each horizon; errors, and seconds of the fit."""
    signals, n = np.column_stack([X, y]), X.shape[1]
    reads = [(column, step) for column in range(signals.shape[1]) for step in (1, 2, 3)]
    rows = np.arange(3, half)
    scale = y[:half].std(axis=0)  # several outputs count alike
    targets = y[rows] / scale if y.shape[1] > 1 else y[rows, 0]
    _, seconds = timed(lambda: learner.fit(lagged(signals, reads, rows), targets))
    found = []
    for horizon in horizons:
        length = len(y) - half if horizon is None else horizon
        starts = np.arange(half, len(y), length)
        # windows side by side, each with the three measured rows before it; the last may be shorter
        padded = np.pad(signals, ((0, length), (0, 0)), mode="edge")
        windows = np.stack([padded[start - 3 : start + length] for start in starts])
        for t in range(3, 3 + length):
            seen = np.column_stack([windows[:, t - step, column] for column, step in reads])
            windows[:, t, n:] = predicted(learner, seen, scale, y)
        answers = windows[:, 3:, n:].reshape(-1, y.shape[1])[: len(y) - half]
        found.append(rms(answers - y[half:]))
    return found, seconds


def predicted(learner, rows, scale, y):
    values = learner.predict(rows).reshape(len(rows), -1)
    return values * scale if y.shape[1] > 1 else values


def held(y, half, horizon):
    starts = np.full(len(y) - half, half) if horizon is None else half + np.arange(len(y) - half) // horizon * horizon
    return rms(y[starts - 1] - y[half:])


def rms(errors):
    return np.sqrt(np.mean(errors * errors, axis=0))


if __name__ == "__main__":
    main()
