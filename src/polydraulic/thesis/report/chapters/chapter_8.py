"""Chapter 8, from measurements: how much data of what quality buys what accuracy, the work that the thesis left."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.tables import Table
from polydraulic.thesis.adaptation_study import SENSORS, torque_limit_study, worn_pump_study
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.measured import JUDGES, SWEEPS, USUAL, Conditions, Outcome, conditions_in_words, outcomes
from polydraulic.thesis.report.catalog import Chapter, Content, Figure, Grid, result
from polydraulic.thesis.report.figures.draw import canvas
from polydraulic.thesis.three_links import SCENARIOS

if TYPE_CHECKING:
    import matplotlib.figure

_THESIS = 0.347  # m, largest end-effector error of the printed task, with networks learnt from a simulation
_PANELS = {
    "minutes": ("minutes", "minutes of operation", 1.0),
    "noise": ("noise", "noise of all sensors [% of range]", 100.0),
    "stroke": ("stroke", "joystick travel that is used [%]", 100.0),
    "dropout": ("dropout", "silent time of each sensor [%]", 100.0),
    "friction": ("friction", "joint friction, times the machine's", 1.0),
    "friction without flow sensors": ("friction", "joint friction, times the machine's; no flow sensors", 1.0),
}

_ADAPTATION: dict[str, Callable[[Machine], Table]] = {"torque limit": torque_limit_study, "worn pumps": worn_pump_study}
_WORN = 10  # minute in which the pumps are worn most; after it they are new


def _all(lab: Lab) -> dict[Conditions, Outcome]:
    """Outcome of every condition, each once."""
    every = list(dict.fromkeys(c for sweep in SWEEPS.values() for c in sweep))
    return dict(zip(every, outcomes(lab, every), strict=True))


def content(lab: Lab) -> Content:
    """Numbers of this chapter."""
    found = _all(lab)
    usual = found[USUAL]
    changes = {name: _change(lab, name) for name in _ADAPTATION}
    rows = [
        [
            conditions_in_words(c),
            str(o.rows),
            " / ".join(f"{o.flow_rms[link]:.1f}" for link in LINKS),
            f"{1e3 * o.median:.0f}",
            f"{1e3 * o.worst:.0f}",
            *(f"{1e3 * o.scenarios[name]:.0f}" for name in SCENARIOS),
        ]
        for c, o in found.items()
    ]
    header = [
        "conditions",
        "rows",
        "flow errors of swing / boom / stick, rms [in3/s]",
        f"{len(JUDGES)} operators of 60 s, median [mm]",
        "worst [mm]",
        *(f"{name} [mm]" for name in SCENARIOS),
    ]
    table = Grid(
        "What networks learnt from measurements reach; largest end-effector errors against exact", header, rows
    )
    return Content(_text(found) + _adaptation_text(changes), {}, _numbers(usual, changes), [table])


def _numbers(usual: Outcome, changes: dict[str, Table]) -> list[dict[str, Any]]:
    limit, worn = changes["torque limit"], changes["worn pumps"]
    judged = "median over judges of the largest end-effector error"
    what = f"learnt from sensors ({conditions_in_words(USUAL)})"
    return [
        result("ours.measured.median_m", "8", f"median of the largest end-effector errors of {len(JUDGES)} operators, {what}", "m", usual.median),
        result("ours.measured.worst_m", "8", f"worst of {len(JUDGES)} operators, {what}", "m", usual.worst),
        result("ours.measured.task_m", "8", f"task: largest end-effector error, {what}", "m", usual.scenarios["task"]),
        result("ours.adaptation.limit_exact_m", "8", f"{judged}, torque limit learnt for 10 min from exact sensors", "m", float(limit["tip.exact"][-1])),
        result("ours.adaptation.worn_exact_m", "8", f"{judged}, pumps that lost 10 %, followed with exact sensors", "m", float(worn["tip.exact"][_WORN])),
        result("ours.adaptation.limit_real_m", "8", f"{judged}, torque limit learnt for 10 min from real sensors", "m", float(limit["tip.real"][-1])),
        result("ours.adaptation.worn_real_m", "8", f"{judged}, pumps that lost 10 %, followed with real sensors", "m", float(worn["tip.real"][_WORN])),
    ]  # fmt: skip


def what_data_buy(lab: Lab) -> Figure:
    """End-effector error over amount and quality of the data."""
    data, known = {}, _all(lab)
    for name, (attribute, label, scale) in _PANELS.items():
        found = [known[c] for c in SWEEPS[name]]
        data[name] = Table(
            {
                label: scale * np.array([float(getattr(c, attribute)) for c in SWEEPS[name]]),
                "median": 1e3 * np.array([o.median for o in found]),
                "worst": 1e3 * np.array([o.worst for o in found]),
            },
            {"median": "mm", "worst": "mm"},
        )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(2, 3, width=12.0, height=2.8)
        for axis, table in zip(axes.ravel(), data.values(), strict=True):
            label = table.names[0]
            for column, style in (("median", "o-"), ("worst", "s--")):
                axis.semilogy(table[label], table[column], style, label=column)
            axis.axhline(1e3 * _THESIS, color="0.5", linestyle=":", label="thesis, task")
            axis.set_xlabel(label)
            axis.set_ylabel("end-effector error [mm]")
            axis.grid(alpha=0.3, which="both")
            axis.legend(fontsize="small")
        return figure

    see = (
        f"Each panel changes one thing of: {conditions_in_words(USUAL)} (the last one leaves out flow sensors, too). Judged by operators whom the networks never saw; the dotted line is "
        "what the thesis reached in its task with networks learnt from a simulation."
    )
    return Figure("How much data of what quality buys what accuracy", see, data, draw)


def _text(found: dict[Conditions, Outcome]) -> str:
    usual, stiff = found[USUAL], found[USUAL._replace(friction=5.0)]
    free, blind = found[USUAL._replace(friction=0.0)], found[USUAL._replace(flow_sensors=False)]
    blind_free, blind_stiff = (found[USUAL._replace(flow_sensors=False, friction=friction)] for friction in (0.0, 5.0))
    inlets = found[USUAL._replace(outlet_sensors=False)]
    quiet, loud, deaf = (found[USUAL._replace(noise=noise)] for noise in (0.0, 0.01, 0.03))
    others = [found[c] for c in SWEEPS["operator"][1:]]

    def median(o: Outcome) -> str:
        return f"{1e3 * o.median:.0f} mm"

    return f"""<p>The thesis learnt from its own simulation and left to others to derive the model from measurements, and to relate how
    incomplete the data are to how accurate the model is. Here a random operator works on the exact machine, friction, end stops and
    relief valves included; sensors with noise and dropouts read spools, port pressures and flows; networks are learnt from nothing
    else, on top of the pumps' flow, the relief setting and the deadband. They go into the machine and drive it with the voltages of
    operators whom they never saw.</p>
    <p><strong>What an engineer can take from it.</strong> {conditions_in_words(USUAL)}: half of the operators stay within
    {1e3 * usual.median:.0f} mm and all of them within {1e3 * usual.worst:.0f} mm over a minute without any correction, the task within
    {1e3 * usual.scenarios["task"]:.0f} mm. Logs of other operators, as long and as good, lead to
    {" and ".join(median(o) for o in others)} (the worst within {" and ".join(f"{1e3 * o.worst:.0f} mm" for o in others)}): what differs
    by less than these do says nothing, the figure's small steps up and down among it. What matters most is coverage: networks learnt
    from operators who hold back fail by metres when others use the whole joystick, in a log as long. Then flow sensors: flows
    reconstructed from joint angles leave out what the oil's compression takes. Without noise the median operator stays within
    {median(quiet)}, with noise of 1 % of the range within {median(loud)}, of 3 % within {median(deaf)}.</p>
    <p><strong>Friction and missing sensors.</strong> The joints of the machine on which the log is made, and on which the networks are
    judged, have no friction, that of the parameter set, or five times as much. With flow sensors the median operator stays within
    {median(free)}, {median(usual)} and {median(stiff)}; the worst within {1e3 * free.worst:.0f}, {1e3 * usual.worst:.0f} and
    {1e3 * stiff.worst:.0f} mm. The networks know valves and pumps, which friction leaves as they are; it changes the pressures that are
    visited, and shows no trend here. With flows from joint angles it is {median(blind_free)}, {median(blind)} and
    {median(blind_stiff)}: the swing's flows are off by {blind.flow_rms["swing"]:.0f} in3/s rms, and by
    {blind_stiff.flow_rms["swing"]:.0f} with five times the friction. A joint that sticks needs pressure before it moves, and oil that
    raises pressure is not seen in an angle. Sensors at the inlets alone, from which the flows out of the actuators follow by the ratio
    of areas, leave the networks of the inlets as good, but not those of the outlets: {median(inlets)}, and {1e3 * inlets.worst:.0f} mm
    for the worst.</p>
    <p>The whole path, with log files, a channel map and a quality report, is in the guide to measured logs
    (docs/measured_logs.md); networks that follow a machine which changes are in docs/dynamic_models.md.</p>"""


def _change(lab: Lab, name: str) -> Table:
    """Errors of networks that follow one change of the machine."""

    def made() -> Table:
        lab.say(f"adaptation: {name}")
        return _ADAPTATION[name](lab.machine)

    return lab.computed.table(f"adaptation {name}", made)


def adaptation(lab: Lab) -> Figure:
    """Errors of networks that follow a machine which changes, over the minutes of operation."""
    data = {name: _change(lab, name) for name in _ADAPTATION}

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.2)
        titles = (
            "(a) a torque limit that the networks never saw",
            f"(b) pumps that lose 10 %, and new ones after {_WORN} min",
        )
        labels = {"fitted": "fitted", **{kind: f"adapted, {kind} sensors" for kind in SENSORS}}
        for axis, table, title in zip(axes[0], data.values(), titles, strict=True):
            for (kind, label), color in zip(labels.items(), ("C3", "C0", "C1"), strict=True):
                axis.semilogy(table["minute"], 1e3 * table[f"tip.{kind}"], "o-", markersize=4, color=color, label=label)
                axis.semilogy(table["minute"], 1e3 * table[f"tip.worst_{kind}"], ":", color=color)
            axis.plot([], [], ":", color="0.3", label="worst judge of each")
            axis.set_xlabel("minutes of operation")
            axis.set_ylabel("end-effector error [mm]")
            axis.set_title(title, fontsize="medium")
            axis.grid(alpha=0.3, which="both")
            axis.legend(fontsize="x-small")
        return figure

    see = (
        "The networks' output layers follow what is measured, within limits and with a way back; the fitted ones stay wrong. Real "
        "sensors have noise, delays and silent times. Replaced pumps, which nobody announces, cost a few minutes."
    )
    return Figure("Networks that follow a machine which changes", see, data, draw)


def _adaptation_text(changes: dict[str, Table]) -> str:
    """What adaptation reaches with exact and with real sensors."""
    limit, worn, real = changes["torque limit"], changes["worn pumps"], SENSORS["real"]

    def tip(table: Table, kind: str, minute: int) -> str:
        return f"{table[f'tip.{kind}'][minute]:.2f} m"

    last = len(limit) - 1
    return f"""<p><strong>A machine that changes.</strong> Networks that follow it (docs/dynamic_models.md) learn from exact sensors and from
    real ones: noise of {100.0 * real.noise:g} % of the range, {1e3 * real.delay:g} ms late and flows {1e3 * real.flow_delay:g} ms, silent
    {100.0 * real.dropout:g} % of the time. Half of the judges stay within so much of the exact run: with a torque limit that the networks
    never saw {tip(limit, "fitted", 0)} before, {tip(limit, "exact", last)} after {last} minutes with exact sensors and
    {tip(limit, "real", last)} with real ones; at the end of the wear {tip(worn, "fitted", _WORN)} if nothing is learnt,
    {tip(worn, "exact", _WORN)} and {tip(worn, "real", _WORN)}; a minute after the pumps were replaced {tip(worn, "exact", _WORN + 1)} and
    {tip(worn, "real", _WORN + 1)}; {len(worn) - 1 - _WORN} minutes after it {tip(worn, "exact", -1)} and {tip(worn, "real", -1)}, where
    the fitted networks have {tip(worn, "fitted", -1)}. Only a reset gives these back at once.</p>"""


CHAPTER = Chapter(8, "From measurements", content, {"8-1": what_data_buy, "8-2": adaptation})
