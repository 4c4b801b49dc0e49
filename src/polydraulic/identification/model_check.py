"""Models checked: where they can go, by a proof; or whether they still hold, by new measurements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import models_of, table_of
from polydraulic.identification.machine_log import as_judged
from polydraulic.identification.validity import Validity, run_validity, validity
from polydraulic.networks.model.lag_words import dynamic_notes
from polydraulic.networks.model.model import Model
from polydraulic.networks.proof.bounds import ModelBounds, RangeCheck, check_range, model_bounds
from polydraulic.tables import Table


@dataclass(frozen=True, eq=False)
class Check:
    """What was found of models; ``str()`` says it.

    Attributes
    ----------
    models : list of Model
        Static ones first where they were judged by data.
    found : sequence of ModelBounds, of RangeCheck, or of Validity
        One a model: proved bounds; whether it stays in a range; whether it holds on data.
    notes : list of str
        What a proof of dynamic models is about.
    """

    models: list[Model]
    found: Sequence[ModelBounds | RangeCheck | Validity]
    notes: list[str]

    @property
    def holds(self) -> bool:
        """Whether every model is proved to stay in the range, or holds on the data; true where neither was asked."""
        return all(isinstance(one, ModelBounds) or one.holds is True for one in self.found)

    def __str__(self) -> str:
        parts = [f"note: {note}" for note in self.notes]
        for model, one in zip(self.models, self.found, strict=True):
            if isinstance(one, ModelBounds):
                parts += _bounds_lines(model, one)
            elif isinstance(one, RangeCheck):
                parts.append(str(one))
            else:
                parts += _validity_lines(model, one)
        return "\n".join(parts)


def check_models(
    models: Sequence[Model] | str | Path,
    *,
    data: Table | str | Path | None = None,
    limits: tuple[float, float] | None = None,
    box: Mapping[str, tuple[float, float]] | None = None,
    max_boxes: int = 20000,
) -> Check:
    """Prove where models can go, anywhere in their domain or a box; or judge them by data that they have not seen.

    Parameters
    ----------
    models : sequence of Model, str or Path
        Or the model file.
    data : Table, str or Path, optional
        Or its file: new measurements. Models are judged next to what was stated when they were fitted; dynamic ones run on their own
        through it, begun anew as often as then; those of a machine read an imported log.
    limits : (low, high), optional
        Is it proved that no output leaves this range, in the output's unit? The proved ranges of outputs and slopes if not given.
    box : mapping from input name to (low, high), optional
        Only in this part of the inputs, in their units; the domain of those that are not named.
    max_boxes : int
        Sub-boxes a region that the proof may take.

    Returns
    -------
    Check

    Raises
    ------
    InputError
        Data together with limits or a box; an input that a model does not read; as `validity`, `run_validity`, `check_range`.
    """
    some = models_of(models)
    if data is not None:
        if limits is not None or box:
            raise InputError("data judge models by measurements; limits and a box go with a proof: give one of them")
        table, _ = table_of(data)
        static, dynamic = ([model for model in some if (model.dynamics is None) == how] for how in (True, False))
        judged = [validity(model, as_judged(model, table)) for model in static]
        judged += run_validity(dynamic, table) if dynamic else []
        return Check([*static, *dynamic], judged, [])
    places = [_place(model, box or {}) for model in some]
    notes = dynamic_notes(some)
    if limits is None:
        bounds = [model_bounds(model, place, max_boxes=max_boxes) for model, place in zip(some, places, strict=True)]
        return Check(some, bounds, notes)
    low, high = limits
    ranges = [check_range(m, low, high, place, max_boxes=max_boxes) for m, place in zip(some, places, strict=True)]
    return Check(some, ranges, notes)


def _place(model: Model, box: Mapping[str, tuple[float, float]]) -> np.ndarray:
    """The model's domain, with the ends that are given in their place."""
    names, found = [variable.name for variable in model.inputs], model.domain()
    for name, ends in box.items():
        if name not in names:
            raise InputError(f"box names the input {name!r}; the model of {model.output.name!r} reads {names}")
        found[names.index(name)] = ends
    return found


def _bounds_lines(model: Model, found: ModelBounds) -> list[str]:
    lines = [f"{model.output}: proved range {found.low:.6g} to {found.high:.6g}"]
    for name, region in zip(model.region_names(), found.regions, strict=True):
        if region is None:
            continue
        lines.append(f"  {name}: {region.low:.6g} to {region.high:.6g}, slopes")
        for variable, (low, high) in zip(model.inputs, region.slopes, strict=True):
            lines.append(f"    by {variable!s:28s} {low:12.5g} to {high:12.5g}")
    return lines


def _validity_lines(model: Model, found: Validity) -> list[str]:
    verdict = "holds" if found.holds else "does not hold any more"
    lines = [f"{model.output}: {verdict}", *(f"  {statement}" for statement in found.statements)]
    for region in found.regions:
        if region["rows"]:
            sizes = f"rms {region['rms']:.4g}, largest {region['largest']:.4g}"
            lines.append(f"    {region['region']}: {region['rows']} rows, {sizes}")
    return lines
