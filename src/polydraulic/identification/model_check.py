"""Models checked: where they can go, by a proof; or whether they still hold, by new measurements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from polydraulic.display import DEFAULT, amount, as_shown, shown_unit
from polydraulic.errors import InputError
from polydraulic.identification.arguments import TIMES, models_of, table_of, unused_in_words
from polydraulic.identification.machine.machine_log import as_judged, judged_by
from polydraulic.identification.validity import Validity, run_validity, validity
from polydraulic.networks.model.lag_words import dynamic_notes
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.shown_model import ends_in, region_names, shown_columns, shown_model
from polydraulic.networks.proof.bounds import (
    Leaving,
    ModelBounds,
    RangeCheck,
    check_range,
    model_bounds,
    range_sentence,
)
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table


@dataclass(frozen=True, eq=False)
class Check:
    """What was found of models; ``str()`` says it.

    Attributes
    ----------
    models : list of Model
        Static ones first where they were judged by data.
    found : sequence of ModelBounds, of RangeCheck, or of Validity
        One per model: proved bounds; whether it stays in a range; whether it holds on data.
    notes : list of str
        What a proof of dynamic models is about; which rows of data are not used.
    units : str
        Of what is said.
    """

    models: list[Model]
    found: Sequence[ModelBounds | RangeCheck | Validity]
    notes: list[str]
    units: str = DEFAULT

    @property
    def holds(self) -> bool:
        """Whether every model is proved to stay in the range, or holds on the data; true where neither was asked."""
        return all(isinstance(one, ModelBounds) or one.holds is True for one in self.found)

    def __str__(self) -> str:
        parts = [f"note: {note}" for note in self.notes]
        for model, one in zip(self.models, self.found, strict=True):
            if isinstance(one, ModelBounds):
                parts += _bounds_lines(model, one, self.units)
            elif isinstance(one, RangeCheck):
                parts.append(_range_line(model, one, self.units))
            else:
                parts += _validity_lines(model, one, self.units)
        return "\n".join(parts)


def check_models(
    models: Sequence[Model] | str | Path,
    *,
    data: Table | str | Path | Sequence[Table | str | Path] | None = None,
    limits: tuple[float, float] | None = None,
    box: Mapping[str, tuple[float, float]] | None = None,
    max_boxes: int = 20000,
    units: str = DEFAULT,
    progress: Progress = quiet,
) -> Check:
    """Prove where models can go, anywhere in their domain or a box; or judge them by data that they have not seen.

    Parameters
    ----------
    models : sequence of Model, str or Path
        Or the model file.
    data : Table, str, Path or sequence of them, optional
        Or its file: new measurements; of several tables, or a pattern such as ``day*.parquet``, no run crosses the end of one. Models are judged next to what was stated when they were fitted; dynamic ones run on their own
        through it, restarted as often as then; those of a machine read an imported log.
    limits : (low, high), optional
        Is it proved that no output leaves this range, in the output's unit? The proved ranges of outputs and slopes if not given.
    box : mapping from input name to (low, high), optional
        Only in this part of the inputs, in their units; the domain of those that are not named.
    max_boxes : int
        Sub-boxes per region that the proof may take.
    units : str
        Of what is said: ``"metric"``, ``"field"`` or ``"si"``; what is in units of its own stays.
    progress : Progress, optional
        Called as each model begins.

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
        table, _ = table_of(data, _read_by(some), TIMES)
        static, dynamic = ([model for model in some if (model.dynamics is None) == how] for how in (True, False))
        judged: list[Validity] = []
        for model in static:
            progress(f"{model.output.name} on the new data", len(judged), len(some))
            judged.append(validity(model, as_judged(model, table), units))
        if dynamic:
            progress("free runs through the new data", len(judged), len(some))
            judged += run_validity(dynamic, table, units)
        unused = unused_in_words(table)
        return Check([*static, *dynamic], judged, [unused] if unused else [], units)
    places = [_place(model, box or {}) for model in some]
    proved: list[ModelBounds | RangeCheck] = []
    for model, place in zip(some, places, strict=True):
        progress(f"proof of {model.output.name}", len(proved), len(some))
        proved.append(
            model_bounds(model, place, max_boxes=max_boxes)
            if limits is None
            else check_range(model, *limits, place, max_boxes=max_boxes)
        )
    return Check(some, proved, dynamic_notes(some), units)


def _read_by(models: Sequence[Model]) -> list[str]:
    """Columns by which models are judged."""
    found: list[str] = []
    for model in models:
        if model.dynamics is not None:
            found += [*(lag.signal for lag in model.dynamics.lags), model.output.name]
        else:
            found += judged_by(model)
    return list(dict.fromkeys(found))


def _place(model: Model, box: Mapping[str, tuple[float, float]]) -> np.ndarray:
    """The model's domain, with the ends that are given in their place."""
    names, found = [variable.name for variable in model.inputs], model.domain()
    for name, ends in box.items():
        if name not in names:
            raise InputError(f"box names the input {name!r}; the model of {model.output.name!r} reads {names}")
        found[names.index(name)] = ends
    return found


def _bounds_lines(model: Model, bounds: ModelBounds, units: str) -> list[str]:
    """Proved ranges of a model's output and slopes, in lines as they are shown."""
    read, unit = shown_model(model, units), model.output.unit

    def span(low: float, high: float) -> str:
        return f"{as_shown(low, unit, units):.6g} to {as_shown(high, unit, units):.6g}"

    lines = [f"{read.output}: proved range {span(bounds.low, bounds.high)}"]
    for name, region in zip(region_names(read), bounds.regions, strict=True):
        if region is None:
            continue
        lines.append(f"  {name}: {span(region.low, region.high)}, slopes")
        for variable, ends in zip(model.inputs, region.slopes, strict=True):
            low, high = (as_shown(end, unit, units) / as_shown(1.0, variable.unit, units) for end in ends)
            lines.append(
                f"    by {Variable(variable.name, shown_unit(variable.unit, units))!s:28s} {low:12.5g} to {high:12.5g}"
            )
    return lines


def _range_line(model: Model, answer: RangeCheck, units: str) -> str:
    """Whether a model stays in a range, in a sentence as it is shown."""
    read, unit = shown_model(model, units), model.output.unit
    names = dict(zip(model.region_names(), region_names(read), strict=True))
    return range_sentence(
        read,
        answer._replace(
            low=as_shown(answer.low, unit, units),
            high=as_shown(answer.high, unit, units),
            asked=ends_in(answer.asked, unit, units),
            leaving=tuple(
                Leaving(
                    names[found.region],
                    shown_columns(found.point[None], [variable.unit for variable in model.inputs], units)[0],
                    as_shown(found.value, unit, units),
                )
                for found in answer.leaving
            ),
            undecided=tuple(names[region] for region in answer.undecided),
        ),
    )


def _validity_lines(model: Model, found: Validity, units: str) -> list[str]:
    verdict, read, unit = (
        "holds" if found.holds else "does not hold any more",
        shown_model(model, units),
        model.output.unit,
    )
    lines = [f"{read.output}: {verdict}", *(f"  {statement}" for statement in found.statements)]
    names = dict(zip(model.region_names(), region_names(read), strict=True))
    for region in found.regions:
        if region["rows"]:
            sizes = f"rms {amount(region['rms'], unit, units)}, largest {amount(region['largest'], unit, units)}"
            lines.append(f"    {names[region['region']]}: {region['rows']} rows, {sizes}")
    return lines
