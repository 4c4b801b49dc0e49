"""Payload and force at the tip from noisy logs of simulated machines: how far they are from what hung and pushed there.

``python benchmarks/tip_loads.py [MACHINE]``: payloads from nothing to full scale while a random operator works for 40 s and at rest, then forces at rest
and in steady motion. Angles have 0.03 deg of noise, pressures 1 bar, every 20 ms. Nothing was chosen by these seeds.
"""

import argparse
from dataclasses import replace

import numpy as np

from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification import estimate_payload, estimate_tip_force
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.tables import Table

NOISE = {"angle": np.radians(0.03), "position": 1e-3, "p_a": 1e5, "p_b": 1e5}
FULL = 2000.0  # kg, what the bucket of the 22 t machine holds
SURE = (
    0.03  # of full scale: windows with a larger standard error are counted, and not among those whose errors are given
)
FORCES = ((3000.0, 0.0, 2000.0), (-4000.0, 1500.0, 5000.0), (0.0, -3000.0, 8000.0), (2000.0, 2000.0, -6000.0))
SEEDS = range(11, 17)


def log_of(machine, scenario, seed):
    """What sensors read of a run."""
    run = simulate(machine, "exact", scenario, every=4)
    rng = np.random.default_rng(seed)
    kept = [name for name in run.names if name == "time" or name.split(".")[-1] in NOISE]
    columns = {name: run[name] + rng.normal(0.0, NOISE.get(name.split(".")[-1], 0.0), len(run)) for name in kept}
    return Table(columns, {name: run.unit(name) for name in kept})


def angle(a, b):
    """Between vectors, deg."""
    share = (a * b).sum(axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return np.degrees(np.arccos(np.clip(share, -1.0, 1.0)))


def payloads(machine):
    """Errors of payloads, of whole logs and of windows of 2 s."""
    for kind in ("at rest", "in motion"):
        means, off, errors = [], [], []
        for load in (0.0, 0.25 * FULL, 0.5 * FULL, FULL):
            for seed in SEEDS:
                moving = kind == "in motion"
                work = random_operator(seed, 40.0, functions=machine.names) if moving else Scenario("rest", 10.0, {})
                hung = replace(work, loads=Loads({}, Payload((0.0,), (load,))))
                found = estimate_payload(machine, log_of(machine, hung, seed))
                means.append(found.mean - load)
                off.append(found.payload - load)
                errors.append(found.error)
        off, errors, means = np.concatenate(off), np.concatenate(errors), np.abs(means)
        sure, rms = errors <= SURE * FULL, lambda values: float(np.sqrt((values**2).mean()))
        print(f"payload {kind}, full scale {FULL:g} kg, {len(means)} logs")
        print(
            f"  whole logs: largest error {means.max():.1f} kg = {means.max() / FULL:.2%}, median {np.median(means):.1f} kg"
        )
        print(f"  {len(off)} windows of 2 s: rms {rms(off):.1f} kg, median standard error {np.median(errors):.0f} kg")
        if sure.mean() > 0.5:
            print(
                f"  {sure.sum()} of them with a standard error up to {SURE:.0%} of full scale: rms {rms(off[sure]):.1f} kg = {rms(off[sure]) / FULL:.2%}"
            )
        print(f"  within twice their standard error: {(np.abs(off) <= 2.0 * errors).mean():.1%}")


def forces(machine):
    """Errors of forces, window by window."""
    steady = {f: Constant(0.3) for f in machine.names[:3]}
    for kind, levers, seconds in (("at rest", {}, 10.0), ("in steady motion", steady, 8.0)):
        off, turned = [], []
        for seed, force in enumerate(FORCES):
            scenario = Scenario(
                "pushed", seconds, levers, loads=Loads(dict(zip("xyz", map(Constant, force), strict=True)), None)
            )
            found = estimate_tip_force(machine, log_of(machine, scenario, seed))
            off.append(np.linalg.norm(found.force - np.array(force), axis=1))
            turned.append(angle(found.force, np.array(force)))
        off, turned = np.concatenate(off), np.concatenate(turned)
        print(f"force {kind}, {len(off)} windows of 2 s, {len(FORCES)} forces of 3.6 to 8.5 kN")
        print(
            f"  error: largest {off.max():.0f} N, median {np.median(off):.0f} N; direction: largest {turned.max():.1f} deg, median {np.median(turned):.1f} deg"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("machine", nargs="?", default="excavator_22t")
    chosen = load_machine(parser.parse_args().machine)
    payloads(chosen)
    forces(chosen)
