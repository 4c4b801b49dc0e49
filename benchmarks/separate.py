"""Learners that need an environment of their own (`.venv-peers`), each fitted in a process that may crash."""

import signal
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from show import left_out

PYTHON = Path(__file__).parent.parent / ".venv-peers" / "bin" / "python"
WORKER = Path(__file__).parent / "peers" / "worker.py"


def separate_learners():
    """Names of the learners that are installed there."""
    if not PYTHON.exists():
        left_out("GMDH, MARS and symbolic regression", "make bench-peers sets up the environment they need")
        return []
    return subprocess.run([PYTHON, WORKER], check=True, capture_output=True, text=True).stdout.splitlines()


def fit_separately(name, folds):
    """Predictions and CPU seconds of each fold, or the reason why there are none.

    `folds` holds (X_train, y_train, X_test) of each fold.
    """
    arrays = {}
    for k, fold in enumerate(folds):
        arrays |= {f"{key}_{k}": value for key, value in zip(("X_train", "y_train", "X_test"), fold, strict=True)}
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "folds.npz", Path(folder) / "found.npz"
        np.savez(source, **arrays)
        done = subprocess.run([PYTHON, WORKER, name, source, target], capture_output=True, text=True, timeout=3600)
        if done.returncode == -signal.SIGXCPU:
            return "timed out"
        if done.returncode < 0:
            return "crashed"
        if done.returncode > 0:
            return f"failed: {done.stderr.strip().splitlines()[-1]}"
        found = np.load(target)
        return [(found[f"predicted_{k}"], float(found[f"seconds_{k}"])) for k in range(len(folds))]
