"""Train the networks that come with the package: ``python -m polydraulic.studies.train FOLDER``.

Writes ``outlets.json``, ``cascade.json``, ``direct.json`` and ``neural.json``; the same seed and versions give the same files.
"""

import sys
from pathlib import Path

from polydraulic.flow.polynomial import ARRANGEMENTS
from polydraulic.networks import save_models
from polydraulic.parameters import load_machine
from polydraulic.studies.circuit_models import learn_inlets, learn_outlets, train_perceptrons


def say(output: str, asked: int, error: float) -> None:
    """Print how far a search has come."""
    print(f"{output}: {asked} points, largest error {error:.3g} m3/s", file=sys.stderr)


if __name__ == "__main__":
    machine, folder = load_machine("cat215b"), Path(sys.argv[1])
    save_models(learn_outlets(machine), folder / "outlets.json")
    save_models(train_perceptrons(machine), folder / "neural.json")
    for arrangement in ARRANGEMENTS:
        save_models(learn_inlets(machine, arrangement, say), folder / f"{arrangement}.json")
