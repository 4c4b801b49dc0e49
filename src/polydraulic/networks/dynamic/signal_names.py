"""Names and units of the signals of dynamic models, whose inputs are lags of them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from polydraulic.networks.dynamic.free_run import dynamics_of
from polydraulic.networks.model.lags import Lag
from polydraulic.networks.model.model import Model, Variable


def renamed(models: Sequence[Model], known: Mapping[str, Variable]) -> list[Model]:
    """Models whose signals have other names and units.

    Parameters
    ----------
    models : sequence of Model
        Dynamic.
    known : mapping from name to Variable
        For each signal, outputs included, what it is to be called.
    """
    found = []
    for model in models:
        dynamics = dynamics_of(model)
        lags = tuple(Lag(known[lag.signal].name, lag.steps) for lag in dynamics.lags)
        units = [known[lag.signal].unit for lag in dynamics.lags]
        names = tuple(Variable(str(lag), unit) for lag, unit in zip(lags, units, strict=True))
        output = known[model.output.name]
        found.append(replace(model, inputs=names, output=output, dynamics=replace(dynamics, lags=lags)))
    return found
