"""Models that are exported together: one list of inputs, one output per model, one name."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.names import c_name, unique_names
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.slopes import distance_outside, model_slopes

_SHOWN = 3  # names that differ in C, of which there may be hundreds


@dataclass(frozen=True)
class Bundle:
    """Models side by side.

    Attributes
    ----------
    name : str
        A C identifier.
    models : tuple of Model
        One per output.
    inputs : tuple of Variable
        Every input once, in the order in which the models name them.
    places : tuple of tuple of int
        For each model, where its inputs stand.
    """

    name: str
    models: tuple[Model, ...]
    inputs: tuple[Variable, ...]
    places: tuple[tuple[int, ...], ...]

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """One per model."""
        return tuple(model.output for model in self.models)

    def identifiers(self) -> tuple[list[str], list[str]]:
        """C identifiers of the inputs and of the outputs."""
        return unique_names([v.name for v in self.inputs]), unique_names([v.name for v in self.outputs])

    def renamed(self) -> dict[str, str]:
        """Names that are not C identifiers, and what they are called in C."""
        names = [v.name for v in (*self.inputs, *self.outputs)]
        inputs, outputs = self.identifiers()
        return {name: c for name, c in zip(names, [*inputs, *outputs], strict=True) if name != c}

    def name_notes(self) -> list[str]:
        """The same in words, if there are any: the first few, and how many more there are."""
        shown = [f"{old} is {new}" for old, new in self.renamed().items()]
        more = f" and {len(shown) - _SHOWN} more" if len(shown) > _SHOWN else ""
        return [f"names: {', '.join(shown[:_SHOWN])}{more}"] if shown else []

    def domain(self) -> np.ndarray:
        """Smallest box around the domains of all models, (n_input, 2)."""
        found = np.tile([np.inf, -np.inf], (len(self.inputs), 1))
        for model, place in zip(self.models, self.places, strict=True):
            box, where = model.domain(), list(place)
            found[where, 0] = np.minimum(found[where, 0], box[:, 0])
            found[where, 1] = np.maximum(found[where, 1], box[:, 1])
        return found

    def predict(self, X: np.ndarray) -> np.ndarray:
        """Outputs (n_row, n_output) for inputs (n_row, n_input)."""
        return np.column_stack([m.predict(X[:, list(p)]) for m, p in zip(self.models, self.places, strict=True)])

    def slopes(self, X: np.ndarray) -> np.ndarray:
        """Jacobians (n_row, n_output, n_input)."""
        found = np.zeros((len(X), len(self.models), len(self.inputs)))
        for k, (model, place) in enumerate(zip(self.models, self.places, strict=True)):
            found[:, k, list(place)] = model_slopes(model, X[:, list(place)])
        return found

    def outside(self, X: np.ndarray) -> np.ndarray:
        """`distance_outside` (n_row,), the largest of all models."""
        pairs = zip(self.models, self.places, strict=True)
        return np.asarray(np.max([distance_outside(model, X[:, list(place)]) for model, place in pairs], axis=0))

    def points(self, n: int, seed: int = 0) -> np.ndarray:
        """Points to test with: two thirds anywhere inside, the others on faces and borders of regions, and outside."""
        random = np.random.default_rng(seed)
        low, high = self.domain().T
        width = np.where(high > low, high - low, 1.0)
        X = np.clip(low + (high - low) * random.uniform(size=(n, len(low))), low, high)
        cuts = [{float(low[i]), float(high[i])} for i in range(len(low))]
        for model, place in zip(self.models, self.places, strict=True):
            for box in model.region_boxes():
                for where, ends in zip(place, box.tolist(), strict=True):
                    cuts[where].update(end for end in ends if np.isfinite(end))
        faces, beyond = X[2 * n // 3 : 5 * n // 6], X[5 * n // 6 :]
        for row in faces:
            i = int(random.integers(len(low)))
            row[i] = random.choice(sorted(cuts[i]))
        beyond[:] = low - 0.3 * width + 1.6 * width * random.uniform(size=beyond.shape)
        return X


def bundle(models: Sequence[Model], *, name: str | None = None) -> Bundle:
    """Put models together.

    Parameters
    ----------
    models : sequence of Model
    name : str, optional
        Name of the whole; that of the output if there is one, "model" if there are more.

    Returns
    -------
    Bundle

    Raises
    ------
    InputError
        No model, two outputs of one name, an input that is also an output, or an input with two units.
    """
    if not models:
        raise InputError("there is no model to export")
    inputs: dict[str, Variable] = {}
    for model in models:
        own = [variable.name for variable in model.inputs]
        if len(set(own)) < len(own):
            raise InputError(f"the inputs of {model.output.name!r} are named {own}: they need different names")
        for variable in model.inputs:
            first = inputs.setdefault(variable.name, variable)
            if first.unit != variable.unit:
                raise InputError(
                    f"input {variable.name!r} is in {first.unit!r} for one model and in {variable.unit!r} for another: "
                    "export them apart"
                )
    outputs = [model.output.name for model in models]
    if len(set(outputs)) < len(outputs):
        raise InputError(f"the outputs are named {outputs}: they must differ")
    if both := sorted(set(outputs) & set(inputs)):
        raise InputError(f"{both[0]!r} is an output of one model and an input of another: export them apart")
    order = list(inputs)
    places = tuple(tuple(order.index(variable.name) for variable in model.inputs) for model in models)
    called = name if name is not None else outputs[0] if len(models) == 1 else "model"
    return Bundle(c_name(called), tuple(models), tuple(inputs.values()), places)
