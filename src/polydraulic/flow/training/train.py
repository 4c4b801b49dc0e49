"""Train the networks that come with the package: ``python -m polydraulic.flow.training.train FOLDER [MACHINE]``.

Writes ``outlets.json``, ``inlets.json``, ``cascade.json``, ``limited.json``, ``direct.json`` and ``neural.json``; the same
seed and versions give the same files.
"""

import sys
from pathlib import Path

from polydraulic.flow.polynomial import TRAINED_ON
from polydraulic.flow.training.circuit_models import learn_direct, learn_outlets, train_perceptrons
from polydraulic.flow.training.mode_models import learn_cascade, learn_inlets, learn_limited
from polydraulic.networks.model.model_file import save_models
from polydraulic.parameters.load import load_machine


def show(what: str, asked: int, most: int) -> None:
    """Print how far a search has come."""
    print(f"{what}, {asked} points of {most} at most", file=sys.stderr)


if __name__ == "__main__":
    folder, machine = Path(sys.argv[1]), load_machine(sys.argv[2] if len(sys.argv) > 2 else TRAINED_ON)
    save_models(learn_outlets(machine), folder / "outlets.json")
    save_models(train_perceptrons(machine), folder / "neural.json")
    for file, learn in {
        "inlets": learn_inlets,
        "cascade": learn_cascade,
        "limited": learn_limited,
        "direct": learn_direct,
    }.items():
        save_models(learn(machine, progress=show), folder / f"{file}.json")
