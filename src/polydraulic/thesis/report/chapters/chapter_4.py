"""Chapter 4, the boom circuit: pump-pressure networks, flow networks, perceptrons, run times."""

from itertools import pairwise
from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.simulation.trajectory import Difference, compare
from polydraulic.thesis.boom_models import N_ROWS, SEED, BoomModels
from polydraulic.thesis.boom_perceptrons import HIDDEN_K_OUT, HIDDEN_Q_IN, HIDDEN_UNITS, PerceptronModels
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Chapter, Content, Grid, Ours, result
from polydraulic.thesis.report.chapters.chapter_3 import NO_FIGURES
from polydraulic.thesis.report.figures.chapter_4 import FIGURES
from polydraulic.thesis.single_link import (
    FULL_TRAVEL_VOLTAGE,
    KINDS,
    SCENARIOS,
    BoomStudy,
    boom_study,
    map_error,
    output_map_error,
    pressure_flow_error,
)
from polydraulic.thesis.timing import TURNED

Errors = dict[str, dict[str, Difference]]  # by flow model, by column


def content(lab: Lab) -> Content:
    """Numbers of chapter 4."""
    study = boom_study(lab)
    spool = study.machine.spool
    cuts = [0.0, *(units.from_si(cut, "in") for cut in (spool.deadband, spool.bypass_closed, spool.knots[-1]))]
    v08, v05 = ({kind: _errors(study, name, kind) for kind in KINDS if kind != "exact"} for name in SCENARIOS)
    pressure = v08["pressure"]
    maps, neural = _map_numbers(study, study.historical), _map_numbers(study, study.perceptrons)
    times = study.run_times
    seconds = {kind: times.median(kind) for kind in ("iterative", "polynomial", "neural")}
    saved = {kind: 100.0 * (1.0 - times.ratio(kind, "iterative").median) for kind in ("polynomial", "neural")}
    spool_peak = units.from_si(float(np.abs(study.run("single_08", "exact")["boom.spool"]).max()), "in")
    fails_elsewhere = (
        f"not met: with the printed voltage our spool reaches {spool_peak:.3f} in, where the inlet is narrow and a pressure "
        f"error hardly matters; at {FULL_TRAVEL_VOLTAGE} V the same networks err by "
        f"{_full_travel_error(study, 'boom.angle', 'deg'):.1f} deg and {_full_travel_error(study, 'boom.rate', 'deg/s'):.1f} deg/s"
    )
    smaller = f"smaller than printed; {NO_FIGURES}"
    slower = "one compiled core of today against a 486/66; the ratio to the iteration is what can be compared"
    closing = _closing_times(study)
    ours = {
        "valves.deadband_in": Ours(cuts[1]),
        "valves.bypass_closed_in": Ours(cuts[2]),
        "valves.travel_in": Ours(cuts[3]),
        "valves.regions_single": Ours([list(pair) for pair in pairwise(cuts)]),
        "single.pressure_model.joint_displacement_error_max_deg": Ours(pressure["boom.angle"].largest, fails_elsewhere),
        "single.pressure_model.joint_velocity_error_max_deg_s": Ours(pressure["boom.rate"].largest, fails_elsewhere),
        "single.aim_maps.Qi_error_max_in3_s": Ours(maps["q_in"], "historical setting; the sign depends on the seed"),
        "single.aim_maps.Qi_error_percent": Ours(maps["q_in_percent"]),
        "single.aim_maps.Qi_worst_region_in": Ours(maps["q_in_region"]),
        "single.aim_maps.Qo_error_max_in3_s": Ours(maps["q_out"], smaller),
        "single.aim_maps.Qo_error_percent": Ours(maps["q_out_percent"], smaller),
        "single.aim_maps.Qi_error_near_opening_in3_s": Ours(maps["q_in_opening"], "largest from 0.188 to 0.207 in"),
        "single.aim_v08.joint_displacement_error_max_deg": Ours(v08["polynomial"]["boom.angle"].largest, smaller),
        "single.aim_v08.joint_displacement_error_time_s": Ours(
            v08["polynomial"]["boom.angle"].time, "depends on the seed: the error is small all along the run"
        ),
        "single.aim_v08.joint_velocity_error_max_deg_s": Ours(v08["polynomial"]["boom.rate"].largest, smaller),
        "single.aim_v08.joint_velocity_error_time_s": Ours(
            v08["polynomial"]["boom.rate"].time, "the valve closes after its second opening near 6 s in both"
        ),
        "single.aim_v05.joint_displacement_error_max_deg": Ours(v05["polynomial"]["boom.angle"].largest, smaller),
        "single.aim_v05.lag_times_s": Ours(closing, "times at which our exact input flow ends"),
        "database.nn_training_points": Ours(float(N_ROWS)),
        "single.nn_maps.hidden_units_Qi": Ours(
            float(HIDDEN_UNITS[int(np.argmin(study.sweep["held_out_rms"]))]),
            f"smallest error on rows held out, of {HIDDEN_UNITS[0]} to {HIDDEN_UNITS[-1]} (Fig 4-18); the printed "
            f"{HIDDEN_Q_IN} are used",
        ),
        "single.nn_maps.Qi_training_error_in3_s": Ours(
            _swept(study, HIDDEN_Q_IN), "rms over the training rows; a quasi-Newton method with exact gradients"
        ),
        "single.nn_maps.Qi_training_error_at_20_hidden_in3_s": Ours(
            _swept(study, 20), "rms; with the same method no number of units is unstable"
        ),
        "single.nn_maps.hidden_units_Qo_each": Ours(float(HIDDEN_K_OUT)),
        "single.nn_maps.Qi_error_max_in3_s": Ours(
            neural["q_in_opening"], f"largest from 0.188 to 0.207 in; {neural['q_in']:.1f} over the whole map"
        ),
        "single.nn_maps.opening_error_time_s": Ours(
            _opening_error_time(study), "time of the largest flow error while the valve opens"
        ),
        "table_1.iterative_s": Ours(seconds["iterative"], slower),
        "table_1.aim_s": Ours(seconds["polynomial"], slower),
        "table_1.reduction_percent": Ours(
            saved["polynomial"],
            "share of the whole loop, negative where the networks take longer: started from the step before, a compiled "
            "iteration needs few sweeps; the closed form is in Table 1",
        ),
        "table_2.iterative_s": Ours(seconds["iterative"], slower),
        "table_2.nn_s": Ours(seconds["neural"], slower),
        "table_2.reduction_percent": Ours(saved["neural"], "negative: every sigmoid is an exponential"),
    }
    tables = [_table(study, "Table 1", "polynomial"), _table(study, "Table 2", "neural"), _comparison(study, v08, v05)]
    return Content(_text(study), ours, _extra(study, v08, v05), tables)


def _errors(study: BoomStudy, scenario: str, kind: str) -> dict[str, Difference]:
    """Differences from exact in the field's units: degrees, psi, in3/s."""
    field = {"rad": "deg", "rad/s": "deg/s", "Pa": "psi", "m3/s": "in3/s", "m": "in"}
    found = {}
    for name, d in compare(study.run(scenario, "exact"), study.run(scenario, kind)).items():
        unit = field.get(d.unit, d.unit)
        sizes = (units.from_si(value, unit) for value in (d.largest, d.rms, d.final))
        largest, rms, final = sizes
        found[name] = Difference(unit, largest, d.time, rms, final)
    return found


def _full_travel_error(study: BoomStudy, column: str, unit: str) -> float:
    runs = study.full_travel
    return abs(units.from_si(compare(runs["exact"], runs["pressure"])[column].largest, unit))


def _map_numbers(study: BoomStudy, models: BoomModels | PerceptronModels) -> dict[str, Any]:
    machine, grid = study.machine, study.grid
    travel = grid["boom.travel"]
    cuts = (0.0, machine.spool.deadband, machine.spool.bypass_closed, machine.spool.knots[-1])
    numbers: dict[str, Any] = {}
    for output in ("q_in", "q_out"):
        found = map_error(models, grid, "boom.q_in") if output == "q_in" else output_map_error(models, study)
        error = units.from_si(found, "in3/s")
        worst = int(np.argmax(np.abs(error)))
        largest = units.from_si(float(grid[f"boom.{output}"].max()), "in3/s")
        numbers[output] = float(error[worst])
        numbers[f"{output}_percent"] = 100.0 * abs(float(error[worst])) / largest
        place = int(np.clip(np.searchsorted(cuts, travel[worst]), 1, 3))
        numbers[f"{output}_region"] = [round(units.from_si(cut, "in"), 6) for cut in cuts[place - 1 : place + 1]]
        opening = (travel > cuts[1]) & (travel < cuts[1] + 0.1 * (cuts[2] - cuts[1]))
        numbers[f"{output}_opening"] = float(np.abs(error[opening]).max())
    return numbers


def _closing_times(study: BoomStudy) -> list[float]:
    run = study.run("single_05", "exact")
    active = run["boom.q_in"] > 0.0
    return [float(run["time"][k]) for k in np.flatnonzero(active[:-1] & ~active[1:])]


def _swept(study: BoomStudy, hidden_units: int) -> float:
    """Rms training error of the sweep in in3/s."""
    return units.from_si(float(study.sweep["training_rms"][HIDDEN_UNITS.index(hidden_units)]), "in3/s")


def _opening_error_time(study: BoomStudy) -> float:
    """Time of the perceptron's largest flow error in the second around the first opening of the valve."""
    exact, neural = study.run("single_05", "exact"), study.run("single_05", "neural")
    opens = exact["time"][np.argmax(exact["boom.q_in"] > 0.0)]
    near = np.abs(exact["time"] - opens) <= 0.5
    error = np.where(near, np.abs(neural["boom.q_in"] - exact["boom.q_in"]), 0.0)
    return float(exact["time"][np.argmax(error)])


def _table(study: BoomStudy, title: str, networks: str) -> Grid:
    """Table 1 or 2: the thesis' columns, and the closed form."""
    times = study.run_times
    labels = {
        "iterative": "iterative, eps 0.05",
        "iterative 0.001": "iterative, eps 0.001",
        "exact": "exact (closed form)",
        networks: "perceptrons" if networks == "neural" else "polynomial, historical networks",
        "ours": "polynomial, networks of this package",
    }
    rows = [
        [
            label,
            f"{1e3 * times.median(kind):.3f}",
            f"{1e9 * times.median(kind) / 2000:.0f}",
            str(times.ratio(kind, "iterative")),
        ]
        for kind, label in labels.items()
    ]
    return Grid(
        f"{title}, measured here: 10 s of motion (2000 steps), warm, CPU time of one core, {TURNED}",
        ["flow model", "ms", "ns a step", "ratio to iterative"],
        rows,
    )


def _comparison(study: BoomStudy, v08: Errors, v05: Errors) -> Grid:
    rows = []
    for kind, label in (("polynomial", "historical"), ("ours", "this package")):
        models = study.historical if kind == "polynomial" else study.ours
        error = units.from_si(map_error(models, study.grid, "boom.q_in"), "in3/s")
        rows.append(
            [
                label,
                f"{models.q_in.n_coefficients} / {models.q_out.n_coefficients}",
                f"{np.abs(error).max():.2f} / {np.sqrt(np.mean(error**2)):.3f}",
                f"{abs(v08[kind]['boom.angle'].largest):.3f}",
                f"{abs(v05[kind]['boom.angle'].largest):.3f}",
            ]
        )
    header = [
        "networks",
        "coefficients of input / output flow",
        "input-flow map error, largest / rms [in3/s]",
        "joint error 0.8 V [deg]",
        "joint error 0.5 V [deg]",
    ]
    return Grid("The same data, regions and kinds of node: the thesis' setting, and this package's", header, rows)


def _extra(study: BoomStudy, v08: Errors, v05: Errors) -> list[dict[str, Any]]:
    flow_error = units.from_si(float(np.abs(pressure_flow_error(study)).max()), "in3/s")
    rows = [
        result("ours.table_1.exact_s", "4.2.2", "computing time for 10 s of motion, exact model", "s", study.run_times.median("exact")),
        result("ours.pressure_model.flow_error_max_in3_s", "4.2.1",
               "pump-pressure networks: largest error of the flow that Eq. (1) gives, over the map", "in3/s", flow_error),
    ]  # fmt: skip
    what = "largest joint displacement error against exact"
    rows += [
        result("ours.v08.ours_joint_error_deg", "4.2.2", f"0.8 V: {what}, networks of this package", "deg",
               v08["ours"]["boom.angle"].largest),
        result("ours.v05.ours_joint_error_deg", "4.2.2", f"0.5 V: {what}, networks of this package", "deg",
               v05["ours"]["boom.angle"].largest),
        result("ours.v08.iterative_joint_error_deg", "4.2.2", f"0.8 V: {what}, iterative", "deg",
               v08["iterative"]["boom.angle"].largest),
        result("ours.v05.iterative_joint_error_deg", "4.2.2", f"0.5 V: {what}, iterative", "deg",
               v05["iterative"]["boom.angle"].largest),
        result("ours.v05.neural_joint_error_deg", "4.3.2", f"0.5 V: {what}, perceptrons", "deg",
               v05["neural"]["boom.angle"].largest),
    ]  # fmt: skip
    stuck = sum(int(str(study.run(name, "iterative").info["steps_not_converged"])) for name in SCENARIOS)
    rows.append(
        result("ours.iterative.steps_not_converged", "4.1", "steps of both runs in which the iteration did not converge",
               "1", float(stuck))
    )  # fmt: skip
    table = study.convergence
    order = np.polyfit(np.log(table["dt"]), np.log(table["single_08"]), 1)[0]
    rows.append(result("ours.loop_order", "4", "order of convergence of the loop, single_08", "1", float(order)))
    return rows


def _text(study: BoomStudy) -> str:
    return f"""<p>The boom circuit: a constant-flow pump, an open-centre valve, two hoses, two cylinders, one link; swing and
    stick are locked. Three networks are grown by region of spool travel from {N_ROWS} random points (seed {SEED}) of the
    circuit without relief valve: pump pressure, input flow, output flow. Errors of maps are taken on a grid of 401 by 401
    points that includes faces and corners; errors of runs are differences from the exact closed form in the same loop.</p>
    <p><strong>Why the pump pressure must not be learnt.</strong> Eq. (1) turns a pressure error into a flow error of
    (K a_i)²/(2 Q_i) times its size. With the inlet wide open that factor is several in3/s for each psi. The thesis saw a
    joint error of 20 deg. Our calibrated circuit shows the failure where the valve opens fully (Figs 4-3, 4-P1, 4-P2), not at
    the printed voltage, where its inlet stays narrow.</p>
    <p><strong>What the networks are for.</strong> The closed form is exact and as fast (Table 1). The networks need no
    orifice areas: that, not speed, is what they offer on one valve.</p>
    <p><strong>Perceptrons</strong> (section 4.3): one network of {HIDDEN_Q_IN} hidden units for the input flow, {HIDDEN_K_OUT}
    for each part of Q_pop(x), trained from as many points by a quasi-Newton method with exact gradients. The thesis'
    training became unstable at 20 units; this one does not.</p>"""


CHAPTER = Chapter(4, "The boom circuit", content, FIGURES)
