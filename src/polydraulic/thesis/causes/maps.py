"""Sections B and C and the outlets: what makes the errors of their maps larger or smaller than printed."""

from typing import NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.flow.dispatch import build_flow
from polydraulic.networks.model.model import Model
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.thesis.excavator import PRESSURE_HIGH, spool_of
from polydraulic.thesis.historical import grow_outlets, grow_series, outlet_conductances
from polydraulic.thesis.three_links import SectionErrors, ThreeLinkStudy, section_errors

FEWER = 3_000  # random points a section; the thesis does not print how many it had


class MapErrors(NamedTuple):
    """Errors of networks in the thesis' setting, in in3/s.

    Attributes
    ----------
    b_typical, b_shut : float
        Stick in section B: 95 % of the errors away from the kinks are smaller; the largest about 0.376 in.
    c_largest : float
        Swing in section C, from 0.282 to 0.376 in.
    """

    b_typical: float
    b_shut: float
    c_largest: float


class OutletError(NamedTuple):
    """Largest error of Q_pop in in3/s/psi^0.5 and where, in inches; of the output flow at 4000 psi in in3/s, and in % of the highest."""

    q_pop: float
    spool: float
    flow: float
    percent: float
    highest: float


def map_errors_as_printed(machine: LayoutMachine, models: list[Model]) -> MapErrors:
    """Errors of sections B and C as section 5.2 states them, at random points, edges and corners included."""
    opens, shut, end = spool_of(machine)
    flow = build_flow("polynomial", machine, models=models)
    b, c = (errors_in_field(section_errors(machine, name, flow, relief=False)) for name in "BC")
    near_shut = np.abs(b.X[:, 1] - shut) < 0.05 * (end - opens)
    away = ~near_shut & (b.X[:, 1] > opens + 0.1 * (end - opens))
    upper = c.X[:, 0] > 0.5 * (opens + shut)
    return MapErrors(
        float(np.quantile(np.abs(b.stick[away]), 0.95)),
        float(np.abs(b.stick[near_shut]).max()),
        float(np.abs(c.swing[upper]).max()),
    )


def errors_in_field(errors: SectionErrors) -> SectionErrors:
    """Errors in in3/s."""
    return SectionErrors(errors.X, units.from_si(errors.swing, "in3/s"), units.from_si(errors.stick, "in3/s"))


def bypass_of_boom(study: ThreeLinkStudy) -> MapErrors:
    """The errors if the stick's bypass closed as evenly as the boom's does."""

    def found() -> list[float]:
        study.lab.say("maps with another bypass")
        machine = study.machine()
        machine = machine.with_values({"functions.stick.valve.bypass": machine.function("boom").valve.bypass})
        return [*map_errors_as_printed(machine, [*grow_series(machine), *study.historical()[2:]])]

    return MapErrors(*study.lab.computed.data("maps with the boom's bypass", found))


def fewer_points(study: ThreeLinkStudy) -> MapErrors:
    """The errors of networks grown from `FEWER` points a section."""

    def found() -> list[float]:
        study.lab.say("maps from fewer points")
        machine = study.machine()
        return [*map_errors_as_printed(machine, [*grow_series(machine, n=FEWER), *study.historical()[2:]])]

    return MapErrors(*study.lab.computed.data("maps from fewer points", found))


def outlet_error(machine: LayoutMachine, link: str, models: list[Model]) -> OutletError:
    """Error of a link's network of Q_pop over its whole travel."""
    spool = np.linspace(-spool_of(machine).end, spool_of(machine).end, 4001)
    exact = outlet_conductances(machine, link, spool)
    (model,) = (model for model in models if model.output.name == f"{link}.k_out")
    error = model.predict(spool[:, None]) - exact
    worst = int(np.argmax(np.abs(error)))
    root = float(np.sqrt(PRESSURE_HIGH - machine.tank.return_pressure))
    flow, highest = (units.from_si(value * root, "in3/s") for value in (float(error[worst]), float(exact.max())))
    return OutletError(
        units.from_si(float(error[worst]), "in3/s/psi^0.5"),
        units.from_si(float(spool[worst]), "in"),
        flow,
        100.0 * abs(flow) / highest,
        highest,
    )


def outlets_without_border(study: ThreeLinkStudy) -> dict[str, OutletError]:
    """By link: the error if the curve of Q_pop is not parted where the bypass closes, at its sharpest kink."""

    def grow() -> list[Model]:
        study.lab.say("outlets without a border at 0.376 in")
        opens = spool_of(study.machine()).deadband
        return grow_outlets(study.machine(), edges=[-opens, opens])

    models = study.lab.computed.models("outlets without border", grow)
    return {link: outlet_error(study.machine(), link, models) for link in ("swing", "stick")}
