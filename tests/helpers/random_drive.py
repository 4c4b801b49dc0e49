"""A drive as nobody would drive: random levers, loads, faults and resets, in pieces of random lengths, and the tape of it."""

import numpy as np

from polydraulic.cockpit.recorded.drives import read_drive
from polydraulic.cockpit.wanted import Wanted


def random_drive(cab, path, seed, n, *, faults=(), resets=True, payloads=True):
    """Drive a cab, record it into a file, and give what was recorded.

    Parameters
    ----------
    cab : Cab
    path : Path
    seed, n : int
        Of the levers, and how often they move.
    faults : sequence of str
        That come and go.
    resets, payloads : bool
        Whether the machine begins anew, and whether something hangs at its tip, now and then.
    """
    rng, wanted = np.random.default_rng(seed), Wanted(locked=False)
    cab.move(wanted, int(rng.integers(1, 50)))
    wanted, texts, first = wanted._replace(recording=1), [], 0

    def go(steps):
        nonlocal first
        cab.move(wanted, steps)
        taped = cab.shown.taped
        texts.extend(taped.blocks[first - taped.first :])
        first = taped.first + len(taped.blocks)

    go(1)
    for k in range(n):
        wanted = wanted._replace(axes=tuple(rng.uniform(-1.0, 1.0, 6)), seq=k)
        if payloads and rng.random() < 0.1:
            wanted = wanted._replace(payload=float(rng.uniform(0.0, 800.0)))
        if rng.random() < 0.2:
            wanted = wanted._replace(faults=tuple(name for name in faults if rng.random() < 0.5))
        if resets and rng.random() < 0.05:
            wanted = wanted._replace(resets=wanted.resets + 1, payload=0.0)
        for _ in range(int(rng.integers(1, 4))):
            go(int(rng.integers(1, 11)))
    wanted = wanted._replace(recording=0)
    go(1)
    path.write_text("".join(texts), encoding="utf-8")
    return read_drive(path)
