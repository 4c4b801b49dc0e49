"""The step of chapter 5: why its numbers differ from the printed ones, from runs with one change each."""

import numpy as np

from polydraulic.thesis.causes.step import PRINTED_ANGLE, step_causes
from polydraulic.thesis.report.catalog import Grid
from polydraulic.thesis.three_links import ThreeLinkStudy


def step_notes(study: ThreeLinkStudy) -> dict[str, str]:
    """Reasons, by the end of a printed number's id."""
    found = step_causes(study)
    end = float(np.degrees(study.run("step", "exact")["swing.angle"][-1]))
    run, follows, both = (found[name] for name in ("as run", "polydraulic's network for the stick", "both"))
    seated, no_relief = (found[name] for name in ("the stick starts at its end stop", "pump relief valve out of reach"))
    cancels = (
        f"two errors cancel here: the stick's network is fast and meets the stop at {run.stops:.2f} s, which sends the swing "
        f"{run.swing_at_stop:.1f} deg ahead by 5 s; then the swing lags. With a stick that is not ahead the swing is "
        f"{abs(follows.swing_end):.1f} deg behind at 13 s, with a stick that starts at its stop {abs(seated.swing_end):.1f} deg"
    )
    return {
        "swing_flow_error_end_in3_s": "in the thesis and here the swing gets less flow from its network than from the exact circuit once the stick stands at its end stop",
        "stick_flow_error_end_in3_s": (
            "the line of the stick that stands at its stop reaches the pump's relief pressure, at which the flow models here let nothing "
            f"in; with the relief valve out of reach the same network gives {abs(no_relief.stick_flow):.1f} in3/s too much"
        ),
        "swing_error_13s_deg": cancels,
        "end_effector_error_max_m": f"reached as the stick stops; {cancels}, and the largest error is {follows.largest:.2f} m",
        "end_effector_error_max_time_s": f"{cancels}, and the error is largest at {follows.time:.1f} s",
        "end_effector_error_X_13s_m": (
            f"{cancels}; and the upper structure ends at {end:.0f} deg, where its error is one along Y. Turned so that it ends at the {np.degrees(PRINTED_ANGLE):.0f} deg that "
            f"the printed errors ask for, and with that stick, the error along X is {both.along_x:+.2f} m (networks less exact; the thesis subtracts the other way round)"
        ),
    }


def step_table(study: ThreeLinkStudy) -> Grid:
    """Errors of the step after one change each."""
    rows = [["thesis", "\u2013", "\u2013", "15.44", "1.400", "13.0", "-1.397", "13.1"]]
    rows += [
        [
            name,
            f"{e.stops:.2f}",
            f"{e.swing_at_stop:+.2f}",
            f"{e.swing_end:+.2f}",
            f"{e.largest:.3f}",
            f"{e.time:.1f}",
            f"{e.along_x:+.3f}",
            f"{e.stick_flow + 0.0:.1f}",
        ]
        for name, e in step_causes(study).items()
    ]
    header = [
        "step, networks in the thesis' setting",
        "their stick stops at [s]",
        "swing error at 5 s [deg]",
        "at 13 s [deg]",
        "end-effector, largest [m]",
        "at [s]",
        "along X at 13 s [m]",
        "stick flow at 13 s [in3/s]",
    ]
    return Grid("Where the step's errors come from: one change each; networks less exact", header, rows)
