"""Passes of other machines by coordinated controllers that know them: a crane, a loader, an excavator with a crossover.

``python benchmarks/control_machines.py [--quick]``: it prints a Markdown table and asserts nothing. Sensors are those of `control.py`: late by 40 ms, with
noise of 0.03 deg and 1 bar; lines are begun and ended at rest, at 0.3 m/s. The loader's arm has one joint before the bucket, which follows the height alone: its line
goes straight up, and its errors are those of the height.
"""

import argparse
import sys

import numpy as np

from control import DELAY, NOISE, PRESSURE, SETTINGS
from polydraulic import load_machine
from polydraulic.control import CoordinatedControl, SensorErrors, joints_at, run_controlled, straight_line
from show import table

# machine: reach, height and pitch at the beginning (None: where positions say), positions of joints; length in m, slope and turn of the pitch in rad
PASSES = {
    "loader_crane": ((6.0, 1.0, -1.57), {}, 3.0, 0.0, 0.0),
    "wheel_loader": (None, {"lift.angle": -0.45}, 2.0, 0.5 * np.pi, 0.0),
    "cat215b_crossover": ((7.2, -1.6, -1.6), {}, 4.0, -0.3, -0.9),
}


def passed(name, seeds):
    """Runs of the machine's own controller, one for each seed of the noise."""
    machine = load_machine(name)
    place, start, length, slope, turn = PASSES[name]
    if place is not None:
        joints = joints_at(machine, place[0], place[1], pitch=place[2])
        start = {f"{f}.{kind(machine, f)}": at for f, at in joints.items()}
    return [
        run_controlled(
            machine,
            CoordinatedControl(machine, settings=SETTINGS),
            lambda tip: straight_line(tip, length=length, speed=0.3, slope=slope, turn=turn, ramp=1.0),
            errors=SensorErrors(NOISE, PRESSURE, DELAY, seed),
            start=start,
            limit=60.0,
        )
        for seed in seeds
    ]


def kind(machine, function):
    """What the position of a function is called."""
    return "position" if machine.link(machine.function(function).moves).joint == "prismatic" else "angle"


def row(name, runs):
    """Errors in cm, seconds, and how far the tip has come in m."""
    _, _, length, slope, turn = PASSES[name]
    away = [np.stack([run[f"tip.{c}"] - run[f"target.{c}"] for c in ("reach", "height")]) for run in runs]
    height_alone = name == "wheel_loader"
    apart = np.concatenate([np.abs(a[1]) if height_alone else np.hypot(*a) for a in away])
    across = np.concatenate([np.sin(slope) * a[0] + np.cos(slope) * a[1] for a in away])
    ways = [
        np.hypot(run["tip.reach"][-1] - run["tip.reach"][0], run["tip.height"][-1] - run["tip.height"][0])
        for run in runs
    ]
    rms = [100.0 * float(np.sqrt(np.mean(np.square(values)))) for values in (apart, across)]
    seconds = max(float(run["time"][-1] - run["time"][0]) for run in runs)
    found = [
        f"{name}, {length:g} m"
        + (" up, height alone" if height_alone else f", bucket turned by {np.degrees(turn):.0f} deg" if turn else ""),
        f"{rms[0]:.2f}",
        f"{100.0 * apart.max():.2f}",
        "-" if height_alone else f"{rms[1]:.2f}",
        f"{seconds:.1f}",
        f"{min(ways):.2f}",
    ]
    print(f"  {found}", file=sys.stderr, flush=True)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one run of each")
    seeds = range(1) if parser.parse_args().quick else range(2)
    heads = ["machine and line", "tip rms, cm", "largest, cm", "across the line rms, cm", "time, s", "way, m"]
    table("Other machines, at 0.3 m/s", heads, [row(name, passed(name, seeds)) for name in PASSES])


if __name__ == "__main__":
    main()
