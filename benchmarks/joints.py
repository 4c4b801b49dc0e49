"""Joints of a public excavator's log, from valve commands alone: learnt from three runs, run on their own through two others.

    python benchmarks/keep.py joints --data FOLDER

FOLDER holds ``rc_excavator/manual_1.csv.gz`` to ``manual_5.csv.gz``: a hydraulic model excavator (1:14) driven by joysticks, about 20 rows a second
with an irregular clock; commands of the valves, strokes of the cylinders, angle of the swing. Logs go through the import, onto a raster of 50 ms.
Windows of 10 s and 30 s begin every half second, from 2 s on, as far as models with play look back; the error at their end, mean over windows,
is given in % of the joint's range in the logs that were learnt from. The swing is said to turn without end. Runs 4 and 5 play no part in any
choice. Joint models go by how strong the rows before a window, as far back as the log's first, show the joints to be; a row of the table has
them without, and one knows them from the run itself: one pair for each joint and run, which no forecast can know, that makes the
mean error least on a grid. ARX models have nothing of the kind. The last row is learnt from these two themselves: what models of this form can do at all,
next to which the row above shows how much differs from run to run. A last table judges each of runs 1 to 3 by a model of the other two, which all choices go by, and by one of
itself, which says what is left where a model has seen how strong the machine was that day.
"""

import argparse
import tempfile
import warnings
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from polydraulic.identification import fit_dynamic, fit_joints
from polydraulic.measure.channels import channel_map
from polydraulic.measure.importing import import_log
from polydraulic.networks.dynamic.free_run import prepare_loop, run_as_strong, run_windows
from polydraulic.networks.dynamic.spans import lagged, rows_of, spans_of
from polydraulic.tables import read_table
from polydraulic.thesis.timing import timed
from show import left_out

NAMES = ("Boom", "Stick", "Bucket", "Swing")
COMMANDS, JOINTS = [f"{name}.command" for name in NAMES], [f"{name}.joint" for name in NAMES]
ENDLESS = [JOINTS[3]]
RASTER, SECONDS, EVERY, FIRST = 0.05, (10, 30), 10, 40
AT_END, SETTLED, OPENED = (
    0.1,
    6,
    14,
)  # a command at the end of its lever: share of its range, rows until the valve is open, and rows in all
LEARNT, JUDGED = (1, 2, 3), (4, 5)
STRENGTHS = np.arange(0.7, 1.21, 0.05)  # that are tried where they are known afterwards


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", required=True, type=Path, help="folder with the public logs")
    parser.add_argument("--networks", action="store_true", help="also DynamicRegressor, which takes minutes to an hour")
    options = parser.parse_args()
    folder = options.data / "rc_excavator"
    if not folder.is_dir():
        left_out("rc_excavator", f"put it into {options.data}")
        return
    with warnings.catch_warnings(), threadpool_limits(1), tempfile.TemporaryDirectory() as into:
        warnings.simplefilter("ignore")
        logs = {k: imported(folder / f"manual_{k}.csv.gz", Path(into)) for k in (*LEARNT, *JUDGED)}
        responses = show([logs[k] for k in LEARNT], [logs[k] for k in JUDGED], options.networks)
        show_speeds(logs, responses)
        show_left_out([logs[k] for k in LEARNT])


def imported(path, into):
    """The log as a table."""
    channels = [{"source": "Time", "role": "time", "unit": "s"}]
    for name in NAMES:
        channels.append({"source": f"{name} Cmd", "name": f"{name}.command", "role": "input"})
        unit = "rad" if name == "Swing" else "cm"
        channels.append({"source": f"{name} Ms", "name": f"{name}.joint", "role": "output", "unit": unit})
    out = into / f"{path.name}.parquet"
    import_log(path, channel_map({"raster": "50 ms", "channel": channels}), out)
    return read_table(out)


def show(learnt, judged, networks):
    scale = np.ptp(np.vstack([log.matrix(JOINTS) for log in learnt]), axis=0)
    print("\n### Mean error at the end of free runs, % of the joint's range: boom / stick / bucket / swing\n")
    print("| model | coefficients | after 10 s | after 30 s | seconds of fit |\n|---|---|---|---|---|")

    def row(name, sizes, seconds, run):
        cells = [
            in_percent(np.concatenate([ends(run, log, round(length / RASTER)) for log in judged]).mean(axis=0) / scale)
            for length in SECONDS
        ]
        print(f"| {name} | {' / '.join(map(str, sizes))} | {' | '.join(cells)} | {seconds:.0f} |", flush=True)

    row("last value held", [0] * 4, 0.0, lambda signals, a, b, low: signals[a - 1, 4:])
    for name, own in (("ARX(3, 3) of all signals", False), ("ARX(3, 3) of its own signals", True)):
        coef, seconds = timed(lambda own=own: arx(learnt, own))
        row(
            name,
            [int((column != 0.0).sum()) for column in coef[0].T],
            seconds,
            lambda s, a, b, low, c=coef: run_arx(c, s, a, b),
        )
    fits = [("joint models (`fit_joints`)", joint_models, learnt)]
    if networks:
        fits.append(("`fit_dynamic`, all chosen", fit_dynamic, learnt))
    fits.append(("`fit_joints`, learnt from the runs that judge", joint_models, judged))
    for name, fit, logs in fits:
        found, seconds = timed(lambda fit=fit, logs=logs: fit(logs, COMMANDS, JOINTS))
        row(name, [model.n_coefficients for model in found.models], seconds, free_run_of(found.models))
        if fit is joint_models:
            same = without_strength(found.models)
            row(
                f"{name}, always as strong as in the mean", [m.n_coefficients for m in same], seconds, free_run_of(same)
            )
        if logs is learnt and fit is joint_models:
            cells = [in_percent(known_afterwards(found.models, judged, round(s / RASTER)) / scale) for s in SECONDS]
            print(f"| {name}, strengths of each run known afterwards | - | {' | '.join(cells)} | - |", flush=True)
            strengths = [(model.output.name, model.dynamics.strength) for model in found.models]
            responses = [one.training["response"] for one in found.models]
    print("\n".join(f"\n{name}: {response}" for name, response in zip(JOINTS, responses, strict=True)), flush=True)
    print("\n### How much strengths differ among runs 1 to 3, standard deviation in %\n")
    print("| joint | both ways | one way against the other | memory in s |\n|---|---|---|---|")
    for name, s in strengths:
        print(f"| {name} | {100.0 * s.spread:.1f} | {100.0 * s.lean:.1f} | {s.memory * RASTER:.0f} |", flush=True)
    return responses


def joint_models(logs, commands, joints):
    """`fit_joints` with a swing that turns without end."""
    return fit_joints(logs, commands, joints, continuous=ENDLESS)


def without_strength(models):
    """The same models, whose joints are always as strong as in the mean."""
    return [replace(model, dynamics=replace(model.dynamics, strength=None)) for model in models]


def show_left_out(logs):
    """Errors of each log by a model of the others, and by one of itself, as the mean over logs."""
    scale = np.ptp(np.vstack([log.matrix(JOINTS) for log in logs]), axis=0)
    print("\n### Runs 1 to 3, each by a model of the other two, and of itself, mean over runs\n")
    print("| model | after 10 s | after 30 s |\n|---|---|---|")
    for name, learnt in (
        ("of the other two", lambda log: [o for o in logs if o is not log]),
        ("of itself", lambda log: [log]),
    ):
        kinds = ("", ", always as strong as in the mean")
        errors = {(kind, length): [] for kind in kinds for length in SECONDS}
        for log in logs:
            models = joint_models(learnt(log), COMMANDS, JOINTS).models
            runs = dict(zip(kinds, map(free_run_of, (models, without_strength(models))), strict=True))
            for (kind, length), found in errors.items():
                found.append(ends(runs[kind], log, round(length / RASTER)).mean(axis=0) / scale)
        for kind in kinds:
            cells = [in_percent(np.mean(errors[kind, length], axis=0)) for length in SECONDS]
            print(f"| {name}{kind} | {' | '.join(cells)} |", flush=True)


def show_speeds(logs, responses):
    """Median speeds of joints that move alone with their valves open as far as they go, in % of their mean over the runs that were learnt from."""
    found = {number: speeds(log, responses) for number, log in logs.items()}
    usual = np.nanmean([found[number] for number in LEARNT], axis=0)
    print(
        "\n### Speed of a joint that moves alone, its command at the end of the lever, % of that in runs 1 to 3: to one side, to the other\n"
    )
    print("| run | boom | stick | bucket | swing |\n|---|---|---|---|---|")
    for number, of_run in found.items():
        cells = [
            ", ".join("-" if np.isnan(share) else f"{100.0 * share:.0f}" for share in pair) for pair in of_run / usual
        ]
        print(f"| {number} | {' | '.join(cells)} |", flush=True)


def speeds(log, responses):
    """Median speed of each joint to each side, (n_joint, 2); NaN where it never moved so."""
    commands, joints = log.matrix(COMMANDS), log.matrix(JOINTS)
    at_rest = [
        (command < response["edges"][0][0]) & (command > response["edges"][1][0])
        for command, response in zip(commands.T, responses, strict=True)
    ]
    found = np.full((len(JOINTS), 2), np.nan)
    for k, (command, response) in enumerate(zip(commands.T, responses, strict=True)):
        others = np.all([still for j, still in enumerate(at_rest) if j != k], axis=0)
        for side, end in enumerate(response["seen"]):
            at_end = np.abs(command - end) < AT_END * abs(response["seen"][0] - response["seen"][1])
            count = np.cumsum(at_end & others)
            whole = log["segment"][OPENED:] == log["segment"][:-OPENED]
            first = np.flatnonzero((count[OPENED:] - count[:-OPENED] == OPENED) & whole) + 1
            moved = joints[first + OPENED - 1, k] - joints[first + SETTLED, k]
            found[k, side] = np.median(moved) / (OPENED - 1 - SETTLED) if len(moved) else np.nan
    return found


def in_percent(shares):
    return " / ".join(f"{100.0 * share:.1f}" for share in shares)


def free_run_of(models):
    """Runs from row `a` to row `b` of a log that begins in row `low`: joints at their end."""
    loop = prepare_loop(models, [*COMMANDS, *JOINTS])
    before = max(model.dynamics.warm_up for model in models)
    return lambda signals, a, b, low: run_windows(loop, signals[:b], [(a, b)], [min(low + before, a)])[b - 1]


def ends(run, log, horizon):
    """Size of the error at the end of each window, (n_window, n_joint)."""
    signals = log.matrix([*COMMANDS, *JOINTS])
    spans = spans_of(log["segment"], np.ones(len(log), dtype=bool))
    starts = [(a, low) for low, high in spans for a in range(low + FIRST, high - horizon + 1, EVERY)]
    return np.abs([run(signals, a, a + horizon, low) - signals[a + horizon - 1, 4:] for a, low in starts])


def known_afterwards(models, logs, horizon):
    """Mean error of each joint at the end of windows with the one pair of strengths for each log that makes it least there."""
    loop = prepare_loop(models, [*COMMANDS, *JOINTS])
    sizes = []
    for log in logs:
        tried = []
        for pair in product(STRENGTHS, STRENGTHS):
            strength = np.tile(pair, (1, len(JOINTS), 1))
            tried.append(
                ends(
                    lambda s, a, b, low, strength=strength: run_as_strong(loop, s[:b], [(a, b)], strength)[-1],
                    log,
                    horizon,
                )
            )
        best = np.argmin([found.mean(axis=0) for found in tried], axis=0)
        sizes.append(np.column_stack([tried[n][:, joint] for joint, n in enumerate(best)]))
    return np.concatenate(sizes).mean(axis=0)


READS = [(column, step) for step in (1, 2, 3) for column in range(8)]


def arx(logs, own):
    """Least squares one step ahead: coefficients (n_lag + 1, n_joint), and the range of the joints."""
    X, y = [], []
    for log in logs:
        signals = log.matrix([*COMMANDS, *JOINTS])
        rows = rows_of([(a + 3, b) for a, b in spans_of(log["segment"], np.ones(len(log), dtype=bool))])
        X.append(np.column_stack([lagged(signals, READS, rows), np.ones(len(rows))]))
        y.append(signals[rows, 4:])
    X, y = np.vstack(X), np.vstack(y)
    coef = np.zeros((X.shape[1], 4))
    for k in range(4):
        read = [n for n, (column, _) in enumerate(READS) if not own or column % 4 == k] + [X.shape[1] - 1]
        coef[read, k] = np.linalg.lstsq(X[:, read], y[:, k], rcond=None)[0]
    return coef, y.min(axis=0), y.max(axis=0)


def run_arx(fitted, signals, a, b):
    coef, low, high = fitted
    signals = signals[:b].copy()
    for t in range(a, b):
        signals[t, 4:] = np.clip(np.append(signals[t - 3 : t][::-1].ravel(), 1.0) @ coef, low, high)
    return signals[b - 1, 4:]


if __name__ == "__main__":
    main()
