"""Train the networks that come with the package, file by file; the same seed and versions give the same files."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.flow.training.circuit_models import learn_direct, learn_outlets
from polydraulic.flow.training.fine_models import learn_fine
from polydraulic.flow.training.layout_perceptrons import inlet_perceptrons
from polydraulic.flow.training.mode_models import learn_cascade, learn_inlets, learn_limited
from polydraulic.networks.model.model_file import save_models
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

# file -> how its networks are learnt, and whether that says how far it has come
FILES: Mapping[str, tuple[Callable[..., Any], bool]] = {
    "outlets": (learn_outlets, False),
    "neural": (inlet_perceptrons, False),
    "inlets": (learn_inlets, True),
    "cascade": (learn_cascade, True),
    "limited": (learn_limited, True),
    "direct": (learn_direct, True),
    "fine": (learn_fine, True),
}


def train_networks(
    machine: LayoutMachine,
    folder: str | Path,
    *,
    files: Mapping[str, tuple[Callable[..., Any], bool]] = FILES,
    progress: Progress = quiet,
) -> list[Path]:
    """Train all networks of a machine from its exact flow model.

    Parameters
    ----------
    machine : LayoutMachine
    folder : str or Path
        Where the model files go, ``outlets.json`` and so on; a file is written as soon as its networks are learnt.
    files : mapping, optional
        Which ones, as `FILES`.
    progress : Progress, optional
        Told each file as it begins, and how its search goes on.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        A place that cannot be written.
    """
    place, total = Path(folder), len(files)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot write there ({error.strerror})") from error
    written = []
    for done, (name, (learn, tells)) in enumerate(files.items()):
        path = place / f"{name}.json"
        progress(path.name, done, total)

        def searching(what: str, asked: int, most: int, path: Path = path, done: int = done) -> None:
            progress(f"{path.name}: {what}, {asked} points", done, total)

        save_models(learn(machine, progress=searching) if tells else learn(machine), path)
        written.append(path)
    return written
