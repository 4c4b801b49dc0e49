"""Grading passes by controllers that know the machine, or learnt it from a log: how far the tip is from where it should be.

``python benchmarks/control.py [--quick] [--seed N] [--figure FILE]``: it prints Markdown tables and asserts nothing. A pass is a straight line of
4 m towards the machine at 0.3 m/s, from rest to rest, with the attachment's angle held. What the controllers get is late by 40 ms and has the
noise of `record --example` (0.03 deg, 1 bar). Logs are four minutes of a random operator who goes to the ends of the levers, recorded by the same
sensors; what is known of the machine before stands in `identify.py`: where valves open, straight lines between conductances that are off by up to half,
pumps off by 5 %, pilots by 10 and 20 %. Gains of the two simpler controllers are the best of a scan on the first pass of each machine.

Errors are those of the tip in the plane of the arm: from the moving target, and across the line.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from identify import recorded
from polydraulic import build_flow, load_machine
from polydraulic.control import (
    ControlSettings,
    CoordinatedControl,
    SensorErrors,
    joints_at,
    run_controlled,
    straight_line,
)
from polydraulic.control.arm import arm_pose, arm_rates, planar_arm
from polydraulic.control.coordinated import servo_of
from polydraulic.identification import fit_machine, identify
from polydraulic.simulation.input_check import full_lever
from polydraulic.thesis.rough_machine import rough_machine
from show import table

DELAY, NOISE, PRESSURE = 0.04, np.radians(0.03), 1e5
PASSES = {  # machine: reach, height, pitch at the beginning, slope towards the machine in rad
    "cat215b": (7.38, -1.63, 0.0, -0.3),
    "excavator_22t": (7.6, 0.0, -2.0, 0.0),
}
FULL = {"cat215b": 1.1, "excavator_22t": 0.8}  # V
SETTINGS = ControlSettings(delay=DELAY)


class JointControl:
    """Inverse kinematics without a model of valves and pumps: joint errors, and if wanted joint rates, to voltages.

    Full lever gives the rate of a joint with its pump's whole flow, and the deadband of the valve is jumped over: a linear map of the lever.
    """

    def __init__(self, machine, gain, integral_gain, forward):
        self.machine, self.dt, self.share, self.reference = machine, SETTINGS.dt, np.ones(()), np.zeros(4)
        self._servo, self._arm = servo_of(machine, SETTINGS), planar_arm(machine)
        self._gains = gain, integral_gain, forward
        self._full = np.array([full_lever(f) for f in machine.functions])
        self._jump = self._servo.opens / self._servo.travel
        self.lag = 0.0
        self.reset()

    def reset(self):
        """Forget everything."""
        n = len(self.machine.names)
        self._live, self._integral, self._begun = np.zeros(4 * n), np.zeros(n), False

    def step(self, measured, wanted):
        """Voltages of the levers."""
        n, dt = len(self.machine.names), self.dt
        if not self._begun:
            self._live[:n], self._begun = measured[:n], True
            self._before = [measured[:n].copy()] * (round(DELAY / dt) + 1)
        pose = arm_pose(self._arm, self._live, 0, 2 * n)
        swing = self._live[self._arm.swing] if self._arm.swing >= 0 else 0.0
        self.reference = np.array([pose.reach, pose.height, swing, pose.pitch])
        arm_rates(self._arm, self._live, 2 * n, n, *wanted, self._servo.slow)
        self._live[:n] = self._live[:n] + dt * self._live[n : 2 * n]
        self._before = [*self._before[1:], self._live[:n].copy()]
        gain, integral_gain, forward = self._gains
        error = self._before[0] - measured[:n]
        error[np.abs(error) < 1e-3] = 0.0
        self._integral += integral_gain * error * dt
        share = (forward * self._live[n : 2 * n] + gain * error + self._integral) / self._servo.speed
        small = np.minimum(np.abs(share) / 0.01, 1.0)
        return self._full * np.clip(np.sign(share) * small * self._jump + (1.0 - self._jump) * share, -1.0, 1.0)


def passed(name, controller, *, speed=0.3, length=4.0, seeds=range(3), truth=None):
    """Runs of a controller on the true machine, one for each seed of the noise."""
    machine = load_machine(name) if truth is None else truth
    reach, height, pitch, slope = PASSES[name]
    start = {f"{f}.angle": at for f, at in joints_at(machine, reach, height, pitch=pitch).items()}

    def line(tip):
        return straight_line(tip, length=length, speed=speed, slope=slope, ramp=max(1.0, speed / 0.6))

    return [
        run_controlled(
            machine, controller, line, errors=SensorErrors(NOISE, PRESSURE, DELAY, seed), start=start, limit=60.0
        )
        for seed in seeds
    ]


def errors(name, runs):
    """Rms and largest distance from the target, and rms across the line, cm; seconds of the longest run, and how far it came, m."""
    slope = PASSES[name][3]
    away = [np.stack([run[f"tip.{c}"] - run[f"target.{c}"] for c in ("reach", "height")]) for run in runs]
    apart = [np.hypot(*a) for a in away]
    across = np.concatenate([np.sin(slope) * a[0] + np.cos(slope) * a[1] for a in away])
    everywhere = np.concatenate(apart)
    seconds = max(float(run["time"][-1] - run["time"][0]) for run in runs)
    way = min(
        np.hypot(run["tip.reach"][-1] - run["tip.reach"][0], run["tip.height"][-1] - run["tip.height"][0])
        for run in runs
    )
    rms = [100.0 * float(np.sqrt(np.mean(np.square(values)))) for values in (everywhere, across)]
    return rms[0], 100.0 * float(everywhere.max()), rms[1], seconds, float(way)


def row(label, name, runs):
    found = errors(name, runs)
    print(f"  {name} {label}: {found}", file=sys.stderr, flush=True)
    return [label, *(f"{value:.2f}" for value in found[:3]), f"{found[3]:.1f}", f"{found[4]:.2f}"]


def best(name, forward, seeds):
    """A joint controller with the gains that come closest on the first pass."""
    machine = load_machine(name)
    tried = [(g, i) for g in (1.0, 2.0, 4.0, 6.0) for i in (0.5, 1.5, 4.0)]
    rms = [errors(name, passed(name, JointControl(machine, *gains, forward), seeds=seeds[:1]))[0] for gains in tried]
    gains = tried[int(np.argmin(rms))]
    print(f"  {name}: gains {gains}", file=sys.stderr, flush=True)
    return JointControl(machine, *gains, forward)


def learnt(name, seed, seconds):
    """A machine identified from a log, and networks learnt from the same log."""
    true = load_machine(name)
    with tempfile.TemporaryDirectory() as folder:
        log = recorded(true, Path(folder), seed, seconds, FULL[name])
    began = time.perf_counter()
    found = identify(log, rough_machine(true, np.random.default_rng(seed))).machine
    print(f"  {name}: identified in {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    networks = fit_machine(log, true, max_regions=6, max_rows=5000).models
    print(f"  {name}: networks, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    return found, networks


def draw(file, runs):
    """Height over reach of the passes of a machine, and their distance from the target."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1)
    for label, run in runs.items():
        above.plot(run["tip.reach"], 100.0 * (run["tip.height"] - run["target.height"]), label=label)
        apart = np.hypot(run["tip.reach"] - run["target.reach"], run["tip.height"] - run["target.height"])
        below.plot(run["time"] - run["time"][0], 100.0 * apart)
    above.set(xlabel="reach [m]", ylabel="tip above target [cm]")
    above.legend(fontsize="small")
    below.set(xlabel="time [s]", ylabel="distance from target [cm]")
    figure.savefig(file, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one run of each, without logs")
    parser.add_argument("--seed", type=int, default=5001, help="of the operator who is recorded")
    parser.add_argument("--figure", type=Path, help="picture of the passes of excavator_22t, .svg")
    options = parser.parse_args()
    seeds = range(1) if options.quick else range(2)
    for name in PASSES:
        true = load_machine(name)
        of = {"circuits and sizes of the machine itself": (CoordinatedControl(true, settings=SETTINGS))}
        if not options.quick:
            found, networks = learnt(name, options.seed, 240.0)
            of["identified from a log"] = CoordinatedControl(found, settings=SETTINGS)
            of["networks from the same log"] = CoordinatedControl(
                true, build_flow("polynomial", true, models=networks), settings=SETTINGS
            )
        of["inverse kinematics, linear levers, PI"] = best(name, 1.0, seeds)
        of["PI on joints alone"] = best(name, 0.0, seeds)
        heads = ["controller", "tip rms, cm", "largest, cm", "across the line rms, cm", "time, s", "way, m"]
        runs = {label: passed(name, controller, seeds=seeds) for label, controller in of.items()}
        table(f"{name}: 4 m at 0.3 m/s", heads, [row(label, name, made) for label, made in runs.items()])
        if options.figure and name == "excavator_22t":
            draw(options.figure, {label: made[0] for label, made in runs.items()})
        fast = {
            "all functions slowed together": CoordinatedControl(true, settings=SETTINGS),
            "each function takes what it gets": CoordinatedControl(true, settings=SETTINGS._replace(shares_flow=False)),
        }
        rows = [row(label, name, passed(name, made, speed=1.2, seeds=seeds)) for label, made in fast.items()]
        table(f"{name}: 4 m at 1.2 m/s asked for, more than the pumps give", heads, rows)


if __name__ == "__main__":
    main()
