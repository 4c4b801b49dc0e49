"""How good a model is on rows that it has not seen: errors, by region too, and intervals with the share that they hold for."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, amount, as_shown, shown_unit, with_unit
from polydraulic.networks.growth.far_values import far_values
from polydraulic.networks.intervals import half_width
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import region_of
from polydraulic.networks.model.shown_model import shown_columns, shown_model
from polydraulic.tables import Table

_TINY = 1e-140  # squares of smaller numbers have lost digits, or are zero
LEVEL = 0.9  # of the intervals
_NEARLY_ONE = 0.99995  # which four digits would show as 1


class Errors(NamedTuple):
    """Errors of answers next to what was measured, in the output's unit."""

    r2: float
    rms: float
    largest: float

    def shown(self, unit: str, units: str = DEFAULT) -> "Errors":
        """The errors of an output in `unit` as they are shown."""
        return Errors(self.r2, as_shown(self.rms, unit, units), as_shown(self.largest, unit, units))


class HeldOut(NamedTuple):
    """Rows that were held out: inputs, output, and what a model fitted without them says."""

    X: np.ndarray
    y: np.ndarray
    predicted: np.ndarray
    by_time: bool  # whether they are blocks of time, or every fifth row


class OutputFit(NamedTuple):
    """A model of one output from all rows, and how one without the rows held out does on these; in the output's unit.

    Attributes
    ----------
    model : Model
        Its `training` states all of the following.
    r2, rms, largest : float
        Of the errors on the rows held out.
    half_widths : list of float
        Of the intervals at `LEVEL`, by region; from half of the rows held out.
    covered : float
        Share of the other half that lies in its interval.
    held : HeldOut
    """

    model: Model
    r2: float
    rms: float
    largest: float
    half_widths: list[float]
    covered: float
    held: HeldOut

    def shown(self, units: str = DEFAULT) -> "OutputFit":
        """The fit with model, errors and rows held out as they are shown: to be read."""
        unit, held = self.model.output.unit, self.held
        return self._replace(
            model=shown_model(self.model, units),
            rms=as_shown(self.rms, unit, units),
            largest=as_shown(self.largest, unit, units),
            half_widths=[as_shown(width, unit, units) for width in self.half_widths],
            held=held._replace(
                X=shown_columns(held.X, [variable.unit for variable in self.model.inputs], units),
                y=as_shown(held.y, unit, units),
                predicted=as_shown(held.predicted, unit, units),
            ),
        )

    def text(self, units: str = DEFAULT) -> str:
        """How good the model is, and where it errs most, in two lines."""
        model, unit = self.model, self.model.output.unit
        return (
            f"{with_unit(model.output.name, shown_unit(unit, units))}: {len(model.networks)} network(s), "
            f"{model.n_coefficients} coefficients; held-out {r2_text(self.r2)}, rms {amount(self.rms, unit, units)}, "
            f"largest {amount(self.largest, unit, units)}\n{self._where(units)}"
        )

    def _where(self, units: str) -> str:
        """Where the largest error is, in one line."""
        model, unit, held = self.model, self.model.output.unit, self.held
        row = int(np.argmax(np.abs(held.predicted - held.y)))
        place = ", ".join(
            f"{variable.name} = {amount(value, variable.unit, units)}"
            for variable, value in zip(model.inputs, held.X[row], strict=True)
        )
        said, true = (amount(values[row], unit, units) for values in (held.predicted, held.y))
        return f"  the largest error is at {place}: {said} predicted, {true} in the table"

    @property
    def doubt(self) -> str:
        """Sentence on a constant, or a model that errs no less than the mean of the rows held out would; empty if it errs less."""
        rows: Any = self.model.training["rows"]
        constant = not any(network.nodes for network in self.model.networks)
        if constant:
            return (
                f"{self.model.output.name}: these inputs do not determine it: of {rows} rows no network explains more than a search as wide "
                "finds by chance, and the model is a constant; give more rows, or inputs that it depends on"
            )
        if self.r2 > 0.0 or np.ptp(self.held.y) == 0.0:
            return ""
        return (
            f"{self.model.output.name}: nothing was learnt from {rows} rows that helps on others: the mean would do as well on those held out "
            f"(R2 {self.r2:.4g}); give more rows, or inputs that it depends on"
        )

    def __str__(self) -> str:
        return self.text()


def far_from_others(table: Table, models: Sequence[Model]) -> dict[str, str]:
    """Sentences on few values of outputs that lie far from all others, and decide what is learnt, by output; rows count from 1."""
    found = {model.output.name: (model, far_values(table[model.output.name])) for model in models}
    return {
        name: far.sentence(str(model.output), 1)
        + ("" if model.n_coefficients else "; as it is, the model is a constant")
        for name, (model, far) in found.items()
        if far is not None
    }


def r2_text(r2: float) -> str:
    """R2 as it is read: what is missing to 1 where four digits would not show it."""
    return f"R2 {r2:.4f}" if r2 < _NEARLY_ONE or r2 == 1.0 else f"R2 1 - {1.0 - r2:.2g}"


def errors_of(measured: np.ndarray, predicted: np.ndarray) -> Errors:
    """R2, rms and largest error of rows, both of shape (n_row,)."""
    error = predicted - measured
    largest = float(np.abs(error).max())
    size = max(largest, float(np.ptp(measured)))
    size = size if 0.0 < size < _TINY else 1.0
    mean_square, spread = float(np.mean((error / size) ** 2)), float(np.var(measured / size))
    r2 = 1.0 - mean_square / spread if spread > 0.0 else 0.0  # as scikit-learn: nothing to explain
    return Errors(r2, size * mean_square**0.5, largest)


def errors_by_region(model: Model, X: np.ndarray, error: np.ndarray) -> list[dict[str, Any]]:
    """Rows, rms and largest error in each region of a model."""
    region = region_of(model.partition, X)
    found = []
    for k, name in enumerate(model.region_names()):
        e = error[region == k]
        sizes = (float(np.sqrt(np.mean(e * e))), float(np.abs(e).max())) if len(e) else (0.0, 0.0)
        found.append({"region": name, "rows": len(e), "rms": sizes[0], "largest": sizes[1]})
    return found


def unit_after(variable: Variable) -> str:
    """Unit as it stands after a number in a sentence; nothing where there is none."""
    return "" if variable.unit in ("", "1") else f" {variable.unit}"


def judged(model: Model, held: HeldOut, rows: int) -> OutputFit:
    """Errors and intervals of a model fitted to `rows` rows, by those held out; written into the model's training, too."""
    error = held.predicted - held.y
    region = region_of(model.partition, held.X)
    # blocks of time, or rows, in turn: one half sets the widths, the other one says whether they hold
    sets = np.arange(len(error)) * 4 // len(error) % 2 == 0 if held.by_time else np.arange(len(error)) % 2 == 0
    sizes = np.abs(error)
    everywhere = half_width(sizes[sets], LEVEL)
    widths = []
    for k in range(len(model.networks)):
        own = half_width(sizes[sets & (region == k)], LEVEL)
        widths.append(own if np.isfinite(own) else everywhere)  # too few rows of its own
    covered = float(np.mean(sizes[~sets] <= np.array(widths)[region[~sets]]))
    errors = errors_of(held.y, held.predicted)
    model.training.update(
        {
            "rows": rows,
            "held_out": "blocks of time" if held.by_time else "every fifth row",
            **{f"held_out_{name}": value for name, value in errors._asdict().items()},
            "held_out_by_region": errors_by_region(model, held.X, error),
            "interval_level": LEVEL,
            "interval_half_widths": widths if np.all(np.isfinite(widths)) else [],
            "interval_covered": covered,
        }
    )
    return OutputFit(model, *errors, widths, covered, held)
