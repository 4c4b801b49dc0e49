"""A run in a few lines: largest pressures, what happened how often, where it ended, and what to be wary of."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, amount, readable
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.tables import Table

_PORTS = (("p_a", "A"), ("p_b", "B"))
# conditions that begin with the one event and end with the other, and what is said of the time in between
_LASTING = {
    "pump relief opens": ("pump relief closes", "pump relief valve open"),
    "line A relief opens": ("line A relief closes", "relief valve of line A open"),
    "line B relief opens": ("line B relief closes", "relief valve of line B open"),
    "line A runs empty": ("line A fills", "line A empty"),
    "line B runs empty": ("line B fills", "line B empty"),
    "low stop met": ("low stop left", "at its low end stop"),
    "high stop met": ("high stop left", "at its high end stop"),
}
_USUAL = ("valve closes", "bypass opens", "crossover closes", "stands again")  # the other halves of what is counted


def run_summary(run: Table, units: str = DEFAULT) -> list[str]:
    """Lines that say what a run was like; those with nothing to say are left out.

    Parameters
    ----------
    run : Table
        From `simulate`.
    units : str
        Of what is printed: ``"metric"``, ``"field"`` or ``"si"``.

    Returns
    -------
    list of str
        Faults, largest pressures with their times, events with their numbers and first times, end position, and lines that begin with
        ``warning:``.
    """
    events: Any = run.info.get("events", [])
    faults: Any = run.info.get("faults", [])
    lines = [f"fault: {one}" for one in faults]
    lines += [f"largest pressures: {', '.join(_pressures(run, units))}"] if "time" in run.names else []
    counts = list(_counts(events))
    lines += [f"events{_raster(run)}:", *(f"  {line}" for line in counts)] if counts else []
    lines += _stands(run, units)
    return [*lines, _end(run, units), *(f"warning: {text}" for text in warnings(run))]


def _raster(run: Table) -> str:
    """How far apart the rows are in which events are looked for, if these are not all steps."""
    apart = float(run["time"][1] - run["time"][0]) if len(run) > 1 else 0.0
    dt: Any = run.info.get("dt", apart)
    located = "rtol" in run.info  # by a method that chooses its own steps
    return f" seen in rows that are {apart:g} s apart; others are missed" if apart > 1.5 * dt and not located else ""


def warnings(run: Table) -> list[str]:
    """What to be wary of in a run: steps that did not converge, rows outside the domain, relief valves, empty lines, end stops."""
    info: Any = run.info
    found = list(info.get("doubtful_inputs", []))
    steps, beyond = info.get("steps", 0), info.get("steps_beyond_log", 0)
    for key, what in (
        ("steps_not_converged", "did not converge: choose a smaller dt"),
        (
            "steps_beyond_log",
            "went beyond travel or pressure of the log that the machine was identified from: curves there are assumed",
        ),
        ("steps_out_of_domain", "left the domain of the flow model, which was held at its border"),
    ):
        count = info.get(key, 0)
        if count and not (key == "steps_out_of_domain" and count == beyond):
            found.append(f"{count} of {steps} steps ({count / steps:.1%}) {what}")
    if count := info.get("rows_beyond_log", 0):
        found.append(
            f"{count} of {len(run)} rows ({count / len(run):.1%}) lie beyond travel or pressure of the log that the machine was identified from"
        )
    for key, what in (
        ("rows_not_converged", "hold flows that did not converge"),
        ("rows_out_of_domain", "lie outside the domain of the flow model, which was held at its border"),
    ):
        if count := info.get(key, 0):
            found.append(f"{count} of {len(run)} rows ({count / len(run):.1%}) {what}")
    last, events = float(run["time"][-1]), info.get("events", [])
    for begins, (ends, words) in _LASTING.items():
        for link in dict.fromkeys(where for _, where, what in events if what in (begins, ends)):
            begun, lasted = _lasting([(t, what) for t, where, what in events if where == link], begins, ends, last)
            found.append(f"{link}: {words} for {readable(lasted, 3)} s in all, first at {begun:.2f} s")
    for at, direction, ahead in info.get("tips", [])[:1]:
        more = len(info["tips"]) - 1
        foreseen = f", foreseen {readable(ahead, 2)} s ahead" if ahead > 0.0 else ""
        again = f", and {more} more times" if more else ""
        found.append(
            f"the machine tips {direction} at {at:.2f} s{foreseen}{again}; this run holds its base, and is not what it would do from there on"
        )
    if dropped := info.get("events_dropped", 0):
        found.append(f"{dropped} more events than are listed: the times above are too short")
    return found


def _stands(run: Table, units: str) -> Iterator[str]:
    """The least margin against tipping, if the run has one."""
    least: Any = run.info.get("stability_least")
    if least is not None:
        at, margin, direction = least
        yield f"least margin against tipping: {amount(margin, 'm', units)} {direction}, at {at:.2f} s"


def _pressures(run: Table, units: str) -> Iterator[str]:
    """Largest pressure of each link's lines and of each pump."""
    for link in _owners(run, ".p_a"):
        sides = [(f"{link}.{port}", side) for port, side in _PORTS if f"{link}.{port}" in run.names]
        if sides:
            name, side = max(sides, key=lambda of: float(run[of[0]].max()))
            yield _peak(run, name, f"{link} {side}", units)
    for circuit in _owners(run, ".p_pump"):
        yield _peak(run, f"{circuit}.p_pump", f"{circuit} pump", units)


def _owners(run: Table, quantity: str) -> list[str]:
    """Functions or circuits of which a run has a quantity."""
    return [name.removesuffix(quantity) for name in run.names if name.endswith(quantity)]


def _peak(run: Table, name: str, words: str, units: str) -> str:
    row = int(np.argmax(run[name]))
    return f"{words} {amount(run[name][row], run.unit(name), units)} at {run['time'][row]:.2f} s"


def _counts(events: Sequence[Sequence[Any]]) -> Iterator[str]:
    """Events by kind: how often at which link, and when first."""
    kinds: dict[str, dict[str, list[float]]] = {}
    for time, link, what in events:
        if what not in _USUAL and what not in {ends for ends, _ in _LASTING.values()}:
            kinds.setdefault(what, {}).setdefault(link, []).append(float(time))
    for what, links in kinds.items():
        times = (f"{link} {len(at)}x from {at[0]:.2f} s" for link, at in links.items())
        yield f"{what:20s} {', '.join(times)}"


def _lasting(events: Sequence[tuple[float, str]], begins: str, ends: str, last: float) -> tuple[float, float]:
    """When a condition held first, and for how long in all; it may hold from the start, and to the end."""
    on: float | None = None
    first, total = np.inf, 0.0
    for time, what in events:
        if what == begins:
            on = time
        elif what == ends:
            begun = 0.0 if on is None else on
            first, total, on = min(first, begun), total + time - begun, None
        if on is not None:
            first = min(first, on)
    return first, total + (0.0 if on is None else last - on)


def _end(run: Table, units: str) -> str:
    told: Any = run.info.get("functions", ())  # of a table that is no run, in the order of its columns
    order = [
        *told,
        *(name.rsplit(".", 1)[0] for name in run.names if not told and name.endswith((".angle", ".position"))),
    ]
    joints = [
        (f"{f}.{w}", run.unit(f"{f}.{w}")) for f in order for w in ("angle", "position") if f"{f}.{w}" in run.names
    ]
    ended = [f"{name.rsplit('.', 1)[0]} {amount(run[name][-1], unit, units)}" for name, unit in joints]
    tip = ", ".join(f"{name[-1]} {amount(run[name][-1], 'm', units)}" for name in EFFECTOR if name in run.names)
    return f"at the end: {', '.join(ended)}" + (f"; tip at {tip}" if tip else "")
