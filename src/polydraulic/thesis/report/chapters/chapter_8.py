"""Chapter 8, from measurements: how much data of what quality buys what accuracy, the work that the thesis left."""

from collections.abc import Callable
from typing import Any

from polydraulic.identification.equations.ways.by_runs import MOST_WINDOWS, SECONDS
from polydraulic.tables import Table
from polydraulic.thesis.adaptation_study import SENSORS
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.measured.conditions import (
    COMMANDS,
    NO_FLOWS,
    NO_PRESSURES,
    SWEEPS,
    USUAL,
    Conditions,
    conditions_in_words,
)
from polydraulic.thesis.measured.study import JUDGE_SECONDS, JUDGES, Outcome, WayErrors
from polydraulic.thesis.report.catalog import Chapter, Content, Grid, Paragraph, result
from polydraulic.thesis.report.figures.chapter_8 import FIGURES, WORN, all_outcomes, change
from polydraulic.thesis.three_links import SCENARIOS


def content(lab: Lab) -> Content:
    """Numbers of this chapter."""
    found = all_outcomes(lab)
    limit, worn = change(lab, "torque limit"), change(lab, "worn pumps")
    text = [*_text(found), _adaptation_text(limit, worn), *_ends()]
    tables = [_both(found), *(_one(found, way) for way in ("networks", "identified"))]
    return Content(text, {}, _numbers(found, limit, worn), tables)


def _named(conditions: Conditions) -> str:
    """What differs from the usual conditions."""
    usual = conditions_in_words(USUAL).split(", ")
    return ", ".join(word for word in conditions_in_words(conditions).split(", ") if word not in usual) or ", ".join(
        usual
    )


def _both(found: dict[Conditions, Outcome]) -> Grid:
    """Both ways side by side."""

    def cells(reached: WayErrors | None) -> list[str]:
        if reached is None:
            return ["\u2013", "\u2013", "\u2013"]
        return [f"{1e3 * reached.median:.0f}", f"{1e3 * reached.worst:.0f}", f"{100.0 * reached.outside:.1f}"]

    rows = [[_named(c), str(o.rows), *cells(o.networks), *cells(o.identified)] for c, o in found.items()]
    header = ["conditions", "rows"] + [
        f"{way}: {what}"
        for way in ("networks", "identified")
        for what in ("median [mm]", "worst [mm]", "steps outside [%]")
    ]
    return Grid(
        f"Networks and the identified machine from the same log: largest end-effector errors of {len(JUDGES)} test runs of {JUDGE_SECONDS:g} s. The first row has the "
        "usual conditions; the others name what differs from them. Steps outside: beyond the domain of a network, or beyond travel or pressure of the log",
        header,
        rows,
    )


def _one(found: dict[Conditions, Outcome], way: str) -> Grid:
    """Errors of flows, and in the thesis' runs, of one way."""
    rows = [
        [
            _named(c),
            " / ".join(f"{reached.flow_rms[link]:.1f}" for link in LINKS),
            *(f"{1e3 * reached.scenarios[name]:.0f}" for name in SCENARIOS),
        ]
        for c, o in found.items()
        if (reached := getattr(o, way)) is not None
    ]
    header = [
        "conditions",
        "input-flow error of swing / boom / stick, rms [in3/s]",
        *(f"{name} [mm]" for name in SCENARIOS),
    ]
    title = {"networks": "Networks", "identified": "The identified machine"}[way]
    return Grid(f"{title}: flow errors, and largest end-effector errors in the runs of chapter 5", header, rows)


def _numbers(found: dict[Conditions, Outcome], limit: Table, worn: Table) -> list[dict[str, Any]]:
    networks, identified, commands = found[USUAL].networks, found[USUAL].identified, found[COMMANDS].identified
    assert networks is not None
    judged = "median over test runs of the largest end-effector error"
    learnt = f"networks learnt from sensor readings ({conditions_in_words(USUAL)})"
    equations = f"machine identified from sensor readings ({conditions_in_words(USUAL)})"
    return [
        result("polydraulic.measured.median_m", "8", f"median of the largest end-effector errors of {len(JUDGES)} test runs, {learnt}", "m", networks.median),
        result("polydraulic.measured.worst_m", "8", f"worst of {len(JUDGES)} test runs, {learnt}", "m", networks.worst),
        result("polydraulic.measured.task_m", "8", f"task: largest end-effector error, {learnt}", "m", networks.scenarios["task"]),
        result("polydraulic.identified.median_m", "8", f"median of the largest end-effector errors of {len(JUDGES)} test runs, {equations}", "m", identified.median),
        result("polydraulic.identified.worst_m", "8", f"worst of {len(JUDGES)} test runs, {equations}", "m", identified.worst),
        result("polydraulic.identified.task_m", "8", f"task: largest end-effector error, {equations}", "m", identified.scenarios["task"]),
        result("polydraulic.identified.commands_m", "8", f"median of the largest end-effector errors of {len(JUDGES)} test runs, machine identified from commands and joint angles alone", "m", commands.median),
        result("polydraulic.adaptation.limit_exact_m", "8", f"{judged}, torque limit learnt for 10 min from ideal sensors", "m", float(limit["tip.exact"][-1])),
        result("polydraulic.adaptation.worn_exact_m", "8", f"{judged}, pumps that lost 10 % of their flow, followed with ideal sensors", "m", float(worn["tip.exact"][WORN])),
        result("polydraulic.adaptation.limit_real_m", "8", f"{judged}, torque limit learnt for 10 min from real sensors", "m", float(limit["tip.real"][-1])),
        result("polydraulic.adaptation.worn_real_m", "8", f"{judged}, pumps that lost 10 % of their flow, followed with real sensors", "m", float(worn["tip.real"][WORN])),
    ]  # fmt: skip


def _text(found: dict[Conditions, Outcome]) -> list[Paragraph]:
    def networks(c: Conditions) -> WayErrors:
        reached = found[c].networks
        assert reached is not None
        return reached

    def equations(c: Conditions) -> WayErrors:
        return found[c].identified

    def of(way: Callable[[Conditions], WayErrors], *conditions: Conditions) -> str:
        medians = [f"{1e3 * way(c).median:.0f}" for c in conditions]
        return _listed(medians) + " mm"

    others = SWEEPS["operator"][1:]
    noise = [USUAL._replace(noise=noise) for noise in (0.0, 0.01, 0.03)]
    silent = [USUAL._replace(dropout=dropout) for dropout in (0.05, 0.2)]
    quiet = [f"{100.0 * c.dropout:.0f}" for c in silent]
    short = SWEEPS["minutes"][0]
    part = SWEEPS["stroke"][0]
    rubbing = [USUAL._replace(friction=friction) for friction in (0.0, 1.0, 5.0)]
    blind = [c._replace(flow_sensors=False) for c in rubbing]
    inlets = USUAL._replace(outlet_sensors=False)
    few = "Networks cannot be learnt without spools and pressures; the equations can be identified through simulation"
    return [
        Paragraph(
            "The thesis learnt its networks from its own simulation. It left two questions to later work: how to derive the model from "
            "measurements, and how its accuracy depends on incomplete data. Here a random operator works on the exact machine, with friction, end stops "
            "and relief valves. Sensors with noise and dropouts read spool positions, port pressures and flows. Two ways lead from the same log to a machine.",
            "What was asked.",
        ),
        Paragraph(
            "Networks take the place of pumps and valves; they know the pumps' flow, the relief setting, the deadband and the rest of the machine, and of orifices "
            "nothing. The other way keeps the circuits' equations and identifies what is in them: curves of all orifices, pumps and pilots, beginning "
            "from a machine whose conductances are off by up to half, pumps by 5 % and pilots by 10 and 20 % (`polydraulic identify`, "
            "docs/identify.md). It reads the levers' voltages as well, which are known in every log; masses and friction are those of the machine in both.",
            "Two ways.",
        ),
        Paragraph(
            f"Both are tested in runs of {JUDGE_SECONDS:g} s by {len(JUDGES)} operators whose work is in no log, over a minute without any correction, against the "
            "exact run. A test run counts with its largest end-effector error; tables and figures have the median and the worst of these. The first "
            "table has both ways side by side, the other two the errors of flows at the states of the exact test runs, and the thesis' own runs. A flow at "
            "relief falls from all to nothing within a few bar, so that a relief setting which is slightly off makes large flow errors there, and hardly moves the end-effector.",
            "How to read the tables.",
        ),
        Paragraph(
            f"Under the usual conditions ({conditions_in_words(USUAL)}) the median is {of(networks, USUAL)} with networks and {of(equations, USUAL)} with the identified machine, the worst "
            f"test run {1e3 * networks(USUAL).worst:.0f} and {1e3 * equations(USUAL).worst:.0f} mm, the thesis' task {1e3 * networks(USUAL).scenarios['task']:.0f} and "
            f"{1e3 * equations(USUAL).scenarios['task']:.0f} mm. Logs of other operators, as long and as good, lead to {of(networks, *others)} with networks and to "
            f"{of(equations, *others)} with identified machines: smaller differences than these, such as the small steps in the figures, mean nothing.",
            "What can be expected.",
        ),
        Paragraph(
            "Structure that is known need not be learnt: this is the difference between the two ways. After "
            f"{short.minutes:g} min the medians are {of(networks, short)} and {of(equations, short)}. Networks buy something else: they need no "
            "equations, so that a valve which nobody can describe is no obstacle. Here the identified equations are those of the machine that was logged; docs/identify.md has "
            "a machine with hysteresis, flow forces and stiction that its file does not declare: there the identified machine is far off until these are free to be found.",
            "Structure or data.",
        ),
        Paragraph(
            f"An operator who uses only {100.0 * part.stroke:.0f} % of the travel of the test runs leaves errors of {of(networks, part)} with networks, even if the log is as long, and of "
            f"{of(equations, part)} with the identified machine, whose curves go on in the shape that they had before; "
            f"{100.0 * equations(part).outside:.0f} % of its steps are flagged as beyond the log. Sensor noise: without any, with 1 % and with 3 % of the range the medians are {of(networks, *noise)} "
            f"with networks and {of(equations, *noise)} with the identified machine. Sensors that are silent {quiet[0]} and {quiet[1]} % of the time leave "
            f"{found[silent[0]].rows} and {found[silent[1]].rows} rows in which all of them read something, and networks learn from these; the medians are {of(networks, *silent)} with networks and "
            f"{of(equations, *silent)} with the identified machine, whose pilots, circuits and outlets each take the rows that have what they need.",
            "Coverage and noise.",
        ),
        Paragraph(
            f"Without sensors of the flows out of actuators, these follow from the flows in by the ratio of the cylinder areas; the medians are {of(networks, inlets)} and "
            f"{of(equations, inlets)}. Without any flow sensors, networks get flows from joint angles, without the flow that compresses the oil, and reach {of(networks, NO_FLOWS)}; the equations balance volumes and "
            f"compression over windows of time, and reach {of(equations, NO_FLOWS)}. {few}: {of(equations, NO_PRESSURES)} from spools and "
            f"angles, {of(equations, COMMANDS)} from commands and angles alone, which tell pumps, pilots and a value or two of each curve. Simulation takes "
            f"{MOST_WINDOWS} windows of {SECONDS:g} s of the log and adds no knots: the machine to begin from has straight lines from where a valve opens to where its "
            "bypass shuts and on to its full travel, and keeps them.",
            "Missing sensors.",
        ),
        Paragraph(
            "The joints of the machine on which the log is recorded, and on which both are tested, have no friction, that of "
            f"the parameter set, or five times as much. With flow sensors the medians are {of(networks, *rubbing)} with networks and {of(equations, *rubbing)} with the identified machine. "
            f"Without them they are {of(networks, *blind)} and {of(equations, *blind)}: a joint that sticks needs pressure before it moves, and oil flow that only raises "
            "the pressure does not show in a joint angle; a balance that counts compression sees it in the pressure.",
            "Friction.",
        ),
    ]  # fmt: skip


def _listed(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else words[0]


def _adaptation_text(limit: Table, worn: Table) -> Paragraph:
    """What adaptation reaches with ideal and with real sensors."""
    real = SENSORS["real"]

    def tip(table: Table, kind: str, minute: int) -> str:
        return f"{table[f'tip.{kind}'][minute]:.2f} m"

    last = len(limit) - 1
    return Paragraph(
        f"Networks that adapt to it learn from ideal sensors or from real ones (noise of {100.0 * real.noise:g} % of the range, "
        f"delays of {1e3 * real.delay:g} ms and, for flows, {1e3 * real.flow_delay:g} ms, silent {100.0 * real.dropout:g} % of the time). All values "
        "are medians over the test runs of the largest end-effector error. Torque limit that was not in the training data: "
        f"{tip(limit, 'fitted', 0)} before adaptation, {tip(limit, 'exact', last)} after {last} minutes with ideal sensors and "
        f"{tip(limit, 'real', last)} with real ones. Pumps that have lost 10 % of their flow: {tip(worn, 'fitted', WORN)} without adaptation, "
        f"{tip(worn, 'exact', WORN)} and {tip(worn, 'real', WORN)} with it. One minute after the pumps were replaced: "
        f"{tip(worn, 'exact', WORN + 1)} and {tip(worn, 'real', WORN + 1)}; {len(worn) - 1 - WORN} minutes after: "
        f"{tip(worn, 'exact', -1)} and {tip(worn, 'real', -1)}, where the networks as first learnt have {tip(worn, 'fitted', -1)}. "
        "Only a reset of the adapted networks restores that at once.",
        "A machine that changes.",
    )


def _ends() -> list[Paragraph]:
    return [
        Paragraph(
            "No real machine was logged: operators are random, sensors have white noise and no delay, and the machine obeys the equations that are identified. Each condition "
            "was logged once.",
            "What was not measured.",
        ),
        Paragraph(
            "The whole procedure with log files, a channel map and a quality report is described in docs/measured_logs.md, which way suits whom in docs/identify.md; networks that "
            "adapt to a machine that changes, in docs/dynamic_models.md.",
        ),
    ]


CHAPTER = Chapter(
    8,
    "From measurements",
    "Networks, and the machine's own equations, learnt from sensor readings instead of a simulation: how much data of what quality is needed, and a "
    "machine that changes.",
    content,
    FIGURES,
)
