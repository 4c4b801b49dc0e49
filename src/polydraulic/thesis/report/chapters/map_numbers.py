"""Errors of the maps of chapter 5: random points of each section with its faces, and the curves of the outlets."""

from typing import NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.thesis.excavator import PRESSURE_HIGH, pump_of, spool_of
from polydraulic.thesis.historical import outlet_conductances
from polydraulic.thesis.report.catalog import Computed
from polydraulic.thesis.three_links import SectionErrors, ThreeLinkStudy, section_errors


def map_numbers(study: ThreeLinkStudy) -> dict[str, Computed]:
    """Numbers of section 5.2, of networks in the thesis' setting."""
    machine = study.machine()
    most = units.from_si(pump_of(machine, "series").flow, "in3/s")
    opens, shut, end = spool_of(machine)
    flow = study.flow("polynomial")
    a, b, c = (_in_field(section_errors(study, name, flow, relief=False)) for name in "ABC")
    near_shut = np.abs(b.X[:, 1] - shut) < 0.05 * (end - opens)
    away = ~near_shut & (b.X[:, 1] > opens + 0.1 * (end - opens))
    typical = float(np.quantile(np.abs(b.stick[away]), 0.95))
    at_shut = float(np.abs(b.stick[near_shut]).max())
    upper = c.X[:, 0] > 0.5 * (opens + shut)
    swing_c = float(np.abs(c.swing[upper]).max())
    outlets = {link: _outlet_error(study, link) for link in ("swing", "stick")}
    differs = "largest at many random points, edges included; the thesis does not print its orifice areas"
    smooth = "flows at 4000 psi; within each region the curve is smooth enough for a cubic"
    return {
        "multi.maps.A_error_in3_s": Computed(float(max(np.abs(a.swing).max(), np.abs(a.stick).max()))),
        "multi.maps.B_stick_error_typical_in3_s": Computed(
            typical, "95 % of the errors away from 0.188 and 0.376 in are smaller"
        ),
        "multi.maps.B_stick_error_typical_percent": Computed(100.0 * typical / most),
        "multi.maps.B_stick_error_at_0376_in3_s": Computed(at_shut, differs),
        "multi.maps.B_stick_error_at_0376_percent": Computed(100.0 * at_shut / most),
        "multi.maps.C_swing_error_max_in3_s": Computed(swing_c, f"from 0.282 to 0.376 in; {differs}"),
        "multi.maps.C_swing_error_max_percent": Computed(100.0 * swing_c / most),
        "multi.maps.swing_Qpop_error_max": Computed(outlets["swing"].q_pop, smooth),
        "multi.maps.swing_Qo_error_max_in3_s": Computed(outlets["swing"].flow, smooth),
        "multi.maps.swing_Qo_error_percent": Computed(outlets["swing"].percent),
        "multi.maps.stick_Qpop_error_max": Computed(outlets["stick"].q_pop, smooth),
        "multi.maps.stick_Qo_error_max_in3_s": Computed(outlets["stick"].flow, smooth),
        "multi.maps.stick_Qo_error_percent": Computed(outlets["stick"].percent),
        "multi.maps.eps_used_for_section_D_maps": Computed(
            0.0, "the maps are computed in closed form, which needs no convergence bound"
        ),
        "database.Qo_max_swing_in3_s": Computed(outlets["swing"].highest),
        "database.Qo_max_stick_in3_s": Computed(outlets["stick"].highest),
        "database.Q_max_swing_stick_in3_s": Computed(most),
    }


def _in_field(errors: SectionErrors) -> SectionErrors:
    """Errors in in3/s."""
    return SectionErrors(errors.X, units.from_si(errors.swing, "in3/s"), units.from_si(errors.stick, "in3/s"))


class _Outlet(NamedTuple):
    """Largest error of Q_pop in in3/s/psi^0.5, of the output flow at 4000 psi in in3/s, and as a share of the highest one."""

    q_pop: float
    flow: float
    percent: float
    highest: float


def _outlet_error(study: ThreeLinkStudy, link: str) -> _Outlet:
    machine = study.machine()
    spool = np.linspace(-spool_of(machine).end, spool_of(machine).end, 4001)
    exact = outlet_conductances(machine, link, spool)
    (model,) = (model for model in study.historical() if model.output.name == f"{link}.k_out")
    error = model.predict(spool[:, None]) - exact
    worst = float(error[np.argmax(np.abs(error))])
    root = float(np.sqrt(PRESSURE_HIGH - machine.tank.return_pressure))
    flow, highest = (units.from_si(value * root, "in3/s") for value in (worst, float(exact.max())))
    return _Outlet(units.from_si(worst, "in3/s/psi^0.5"), flow, 100.0 * abs(flow) / highest, highest)
