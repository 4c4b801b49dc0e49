"""Figures of chapter 5, maps: Figs 5-1 to 5-11."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from polydraulic import units
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.machine.pump import limited_pump
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import PRESSURE_HIGH, pump_of, spool_of, without_relief
from polydraulic.thesis.historical import outlet_conductances, sections, series_flows
from polydraulic.thesis.report.catalog import Figure
from polydraulic.thesis.report.figures.draw import canvas, map_panel
from polydraulic.thesis.report.figures.schematic import draw_schematic
from polydraulic.thesis.three_links import section_maps, three_link_study

if TYPE_CHECKING:
    import matplotlib.figure

_N = 101  # grid lines of a map
Panel = tuple[str, Table]  # title, and a map in its last column


def in_field(columns: dict[str, tuple[np.ndarray, str]]) -> Table:
    """Columns in the field's units."""
    return Table(
        {name: units.from_si(values, unit) for name, (values, unit) in columns.items()},
        {name: unit for name, (_, unit) in columns.items()},
    )


def map_figure(title: str, see: str, panels: list[Panel], *, error: bool) -> Figure:
    """Figure of maps side by side, each the last column of its table over the first two."""

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, len(panels), width=4.2 * len(panels), height=3.2)
        for axis, (name, table) in zip(axes[0], panels, strict=True):
            map_panel(axis, table, table.names[-1], name, error=error)
        return figure

    names = [""] if len(panels) == 1 else [chr(ord("a") + place) for place in range(len(panels))]
    return Figure(title, see, dict(zip(names, (table for _, table in panels), strict=True)), draw)


def _series_panel(
    lab: Lab, title: str, link: str, across: tuple[float, float], other: float, *, alike: bool, error: bool
) -> Panel:
    """Map over a link's travel and pressure in SI; the other link's travel is fixed, its pressure zero or `alike`."""
    travel, pressure = (
        grid.ravel() for grid in np.meshgrid(np.linspace(*across, _N), np.linspace(0.0, PRESSURE_HIGH, _N))
    )
    fixed = np.full(len(travel), other)
    beside = pressure if alike else np.zeros(len(travel))
    columns = (travel, fixed, pressure, beside) if link == "swing" else (fixed, travel, beside, pressure)
    X = np.column_stack(columns)
    place = ("swing", "stick").index(link)
    values = series_flows(lab.machine, X)[:, place]
    if error:
        values = section_maps(three_link_study(lab), X)[link] - values
    name = f"{link}.q_in{' error' if error else ''}"
    return title, in_field(
        {f"{link}.travel": (travel, "in"), f"{link}.p_in": (pressure, "psi"), name: (values, "in3/s")}
    )


def _inch(value: float) -> float:
    return units.to_si(value, "in")


def schematic(lab: Lab) -> Figure:
    """Fig 5-1: pump, the two valves in series, and the actuators."""
    flow = pump_of(lab.machine, "series").flow
    table = in_field({"series pump flow": (np.array([flow]), "in3/s")})
    see = "Only Q_e1, the flow that the swing's valve passes on, reaches the stick's valve: the swing has priority."
    return Figure("Swing and stick: two open-centre valves in series", see, {"": table}, draw_schematic)


def swing_map(lab: Lab) -> Figure:
    """Fig 5-2: swing input flow with the stick idle."""
    panel = _series_panel(lab, "x_st = 0", "swing", (0.0, spool_of(lab.machine).end), 0.0, alike=False, error=False)
    see = "Below 0.188 in (sections A and B) no flow; from 0.188 to 0.376 in (C and D) the flow depends on the pressure; beyond (E) it is the whole pump flow."
    return map_figure("Swing input flow", see, [panel], error=False)


def stick_map(lab: Lab) -> Figure:
    """Fig 5-3: stick input flow with the swing idle."""
    panel = _series_panel(lab, "x_sw = 0", "stick", (0.0, spool_of(lab.machine).end), 0.0, alike=False, error=False)
    return map_figure(
        "Stick input flow",
        "With the swing idle the stick's map has the shape of the boom's (Fig 4-8).",
        [panel],
        error=False,
    )


def passed_maps(lab: Lab) -> Figure:
    """Fig 5-4: stick input flow when the swing leaves it less."""
    machine = without_relief(lab.machine)
    valve, pump = machine.function("stick").valve, pump_of(machine, "series")
    fed_by = limited_pump(
        pump.flow, pump.relief, machine.tank.return_pressure, pump._replace(torque_limit_enabled=False)
    )
    travel, pressure = (
        grid.ravel()
        for grid in np.meshgrid(np.linspace(0.0, spool_of(lab.machine).end, _N), np.linspace(0.0, PRESSURE_HIGH, _N))
    )
    panels = []
    for letter, passed in zip("abc", (50.0, 100.0, 150.0), strict=True):
        fed = np.full(len(travel), units.to_si(passed, "in3/s"))
        q = sample_valves([valve], fed_by, travel[:, None], pressure[:, None], fed).q_in[:, 0]
        columns = {"stick.travel": (travel, "in"), "stick.p_in": (pressure, "psi"), "stick.q_in": (q, "in3/s")}
        panels.append((f"({letter}) Q_12 = {passed:g} in3/s", in_field(columns)))
    see = "The less flow reaches the stick's valve, the wider it must open before flow enters the cylinder: a family of maps that one network has to learn."
    return map_figure("Stick input flow in section D, by the flow that the swing leaves", see, panels, error=False)


def _outlet_panel(lab: Lab, title: str, link: str, *, error: bool) -> Panel:
    """Output flow over spool displacement and pressure."""
    travel, back = spool_of(lab.machine).end, lab.machine.tank.return_pressure
    spool, pressure = (
        grid.ravel() for grid in np.meshgrid(np.linspace(-travel, travel, 2 * _N - 1), np.linspace(0.0, PRESSURE_HIGH, _N))
    )  # fmt: skip
    conductance = outlet_conductances(lab.machine, link, spool)
    if error:
        models = {model.output.name: model for model in three_link_study(lab).historical()}
        conductance = models[f"{link}.k_out"].predict(spool[:, None]) - conductance
    q = conductance * np.sqrt(np.maximum(pressure - back, 0.0))
    name = f"{link}.q_out{' error' if error else ''}"
    return title, in_field({f"{link}.spool": (spool, "in"), f"{link}.p_out": (pressure, "psi"), name: (q, "in3/s")})


def _outlets(title: str, see: str, *, error: bool) -> Callable[[Lab], Figure]:
    def make(lab: Lab) -> Figure:
        panels = [_outlet_panel(lab, "(a) swing", "swing", error=error), _outlet_panel(lab, "(b) stick", "stick", error=error)]  # fmt: skip
        return map_figure(title, see, panels, error=error)

    return make


def _errors(
    title: str, see: str, link: str, section: str, others: tuple[float, ...], *, alike: bool = False
) -> Callable[[Lab], Figure]:
    """Error maps of a link in a section, at travels of the other link in inches."""

    def make(lab: Lab) -> Figure:
        box = sections(lab.machine)[section]
        across = box.swing if link == "swing" else box.stick
        across = (across[0] + 1e-6 * across[1], across[1])  # a border belongs to the section below it
        name = "x_st" if link == "swing" else "x_sw"
        panels = []
        for place, other in enumerate(others):
            letter = f"({chr(ord('a') + place)}) " if len(others) > 1 else ""
            panels.append(
                _series_panel(
                    lab, f"{letter}{name} = {other:g} in", link, across, _inch(other), alike=alike, error=True
                )
            )
        return map_figure(title, see, panels, error=True)

    return make


FIGURES: dict[str, Callable[[Lab], Figure]] = {
    "5-1": schematic,
    "5-2": swing_map,
    "5-3": stick_map,
    "5-4": passed_maps,
    "5-5": _outlets(
        "Output flows",
        "Both grow with the square root of the line pressure; the stick is throttled on one side only.",
        error=False,
    ),
    "5-6": _errors(
        "Stick input flow error, section B, thesis' setting",
        "Largest near 0.376 in, where the slope of the map changes, and along the curve on which flow begins.",
        "stick", "B", (0.0,)),
    "5-7": _errors(
        "Swing input flow error, section C, thesis' setting",
        "Largest along the curve on which flow begins. The stick's travel has little effect: its valve is closed below 0.188 in.",
        "swing", "C", (0.0, 0.094, 0.187)),
    "5-8": _errors(
        "Swing input flow error, section D, thesis' setting, P_i1 = P_i2",
        "A network of four inputs: its error grows with the opening of the stick's valve.",
        "swing", "D", (0.190, 0.376, 0.563), alike=True),
    "5-9": _errors(
        "Stick input flow error, section D, thesis' setting, P_i1 = P_i2",
        "One network has to represent the whole family of Fig 5-4. It smooths the kink at 0.376 in, with an error of up to a third of the pump's flow.",
        "stick", "D", (0.190, 0.270, 0.375), alike=True),
    "5-10": _errors(
        "Swing input flow error, section E, thesis' setting",
        "The bypass is shut: the swing receives the whole pump flow at any pressure.",
        "swing", "E", (0.0,)),
    "5-11": _outlets(
        "Output flow error, thesis' setting",
        "The error of Q_pop is multiplied by the square root of the pressure drop. It is small here because the regions end where the curve bends.",
        error=True,
    ),
}  # fmt: skip
