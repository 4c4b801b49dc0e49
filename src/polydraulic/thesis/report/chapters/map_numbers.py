"""Errors of the maps of chapter 5: random points of each section with its faces, and the curves of the outlets."""

import numpy as np

from polydraulic import units
from polydraulic.thesis.boom_models import N_ROWS
from polydraulic.thesis.causes.maps import (
    FEWER,
    bypass_of_boom,
    errors_in_field,
    fewer_points,
    map_errors_as_printed,
    outlet_error,
    outlets_without_border,
)
from polydraulic.thesis.excavator import pump_of
from polydraulic.thesis.report.catalog import Computed
from polydraulic.thesis.three_links import ThreeLinkStudy, section_errors


def map_numbers(study: ThreeLinkStudy) -> dict[str, Computed]:
    """Numbers of section 5.2, of networks in the thesis' setting."""
    machine = study.machine()
    most = units.from_si(pump_of(machine, "series").flow, "in3/s")
    flow, models = study.flow("polynomial"), study.historical()
    a = errors_in_field(section_errors(machine, "A", flow, relief=False))
    found, bypass, fewer = map_errors_as_printed(machine, models), bypass_of_boom(study), fewer_points(study)
    outlets = {link: outlet_error(machine, link, models) for link in ("swing", "stick")}
    whole = outlets_without_border(study)
    stick = (
        f"the stick's bypass, derived from the pressures of section 5.3.2, closes late and then at once, between 0.365 and 0.376 in; with "
        f"the boom's bypass in its place such networks have {bypass.b_typical:.1f} in3/s away from the kinks and {bypass.b_shut:.1f} at 0.376 in"
    )
    swing = (
        f"depends on the number of random points, which is not printed: {found.c_largest:.1f} in3/s from {N_ROWS:,} a section, "
        f"{fewer.c_largest:.1f} from {FEWER:,}"
    )
    smooth = {
        link: f"the curve is parted at 0.376 in here, where it has its kink; parted at the deadband alone, the error is "
        f"{error.q_pop:+.2f} in3/s/psi^0.5 at {error.spool:+.3f} in, where the thesis has its own, and {abs(error.flow):.0f} in3/s or "
        f"{error.percent:.1f} % at 4000 psi"
        for link, error in whole.items()
    }
    return {
        "multi.maps.A_error_in3_s": Computed(float(max(np.abs(a.swing).max(), np.abs(a.stick).max()))),
        "multi.maps.B_stick_error_typical_in3_s": Computed(
            found.b_typical, f"95 % of the errors away from 0.188 and 0.376 in are smaller; {stick}"
        ),
        "multi.maps.B_stick_error_typical_percent": Computed(100.0 * found.b_typical / most, stick),
        "multi.maps.B_stick_error_at_0376_in3_s": Computed(found.b_shut, f"largest, edges included; {stick}"),
        "multi.maps.B_stick_error_at_0376_percent": Computed(100.0 * found.b_shut / most, stick),
        "multi.maps.C_swing_error_max_in3_s": Computed(found.c_largest, swing),
        "multi.maps.C_swing_error_max_percent": Computed(100.0 * found.c_largest / most, swing),
        "multi.maps.swing_Qpop_error_max": Computed(outlets["swing"].q_pop, smooth["swing"]),
        "multi.maps.swing_Qo_error_max_in3_s": Computed(outlets["swing"].flow, smooth["swing"]),
        "multi.maps.swing_Qo_error_percent": Computed(outlets["swing"].percent, smooth["swing"]),
        "multi.maps.stick_Qpop_error_max": Computed(outlets["stick"].q_pop, smooth["stick"]),
        "multi.maps.stick_Qo_error_max_in3_s": Computed(outlets["stick"].flow, smooth["stick"]),
        "multi.maps.stick_Qo_error_percent": Computed(outlets["stick"].percent, smooth["stick"]),
        "multi.maps.eps_used_for_section_D_maps": Computed(
            0.0, "the maps are computed in closed form, which needs no convergence bound"
        ),
        "database.Qo_max_swing_in3_s": Computed(outlets["swing"].highest),
        "database.Qo_max_stick_in3_s": Computed(outlets["stick"].highest),
        "database.Q_max_swing_stick_in3_s": Computed(most),
    }
