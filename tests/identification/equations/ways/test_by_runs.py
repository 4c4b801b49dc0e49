"""What is left to simulation, and a machine identified from commands and positions alone."""

import re

import numpy as np
import pytest

from helpers.operator_log import operator_log
from polydraulic import InputError, load_machine
from polydraulic.identification import identify, write_identification_card
from polydraulic.identification.equations.free_numbers import freedom
from polydraulic.identification.equations.shooting import fit
from polydraulic.identification.equations.ways.by_runs import entries_left, lacking_for_runs
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.tables import Table

NAME = "wheel_loader"


def commands_and_angles(log):
    names = [n for n in log.names if n == "time" or n.endswith((".voltage", ".angle", ".position"))]
    return Table({n: log[n] for n in names}, {n: log.unit(n) for n in names})


def begun(true, factor, ends):
    return true.with_values({n.path: factor * n.value for n in true.numbers if n.path.endswith(ends)})


def test_curves_pumps_and_pilots_are_left_unless_they_were_found():
    machine = load_machine(NAME)
    so_far = SoFar(machine, freedom(machine, {}, ()), "identified from a log")
    left = entries_left(so_far, ("functions.tilt.",))
    assert {"circuits.work.pump.flow", "functions.lift.valve.bypass", "functions.lift.pilot.dead_time"} <= set(left)
    assert not [path for path in left if path.startswith("functions.tilt.") or path.endswith(".knots")]
    limited = machine.circuit("work").pump.torque_limit_enabled
    assert ("circuits.work.pump.torque_limit_start" in left) == limited
    assert not so_far.kept
    joined = load_machine("cat215b_crossover")
    left = entries_left(SoFar(joined, freedom(joined, {}, ()), "identified from a log"), ())
    assert {f"{c.pump_path}.flow" for c in joined.circuits} <= set(left)
    named = SoFar(machine, freedom(machine, {}, ["functions.lift.*"]), "identified from a log")
    left = entries_left(named, ())
    assert "functions.lift.friction.coulomb" in left
    assert "functions.lift.stops.low" not in left
    assert any(line.startswith("functions.lift.stops.low: kept; sizes, places") for line in named.kept)
    asked = SoFar(machine, freedom(machine, {}, ["functions.lift.valve.hysteresis"]), "identified from a log")
    assert not entries_left(asked, ())
    assert asked.kept == [
        "functions.lift.valve.hysteresis: kept; the machine does not declare it, and it shows between a pilot and its measured spool alone"
    ]


def test_a_simulation_that_was_interrupted_goes_on(tmp_path, monkeypatch):
    true, parts = load_machine(NAME), tmp_path / "parts"
    log, free = commands_and_angles(operator_log(NAME, seconds=13.0)), ["functions.lift.pilot.gain"]
    start, slopes, made = begun(true, 1.12, ("lift.pilot.gain",)), fit.window_slopes, []

    def counted(*given):
        made.append(None)
        return slopes(*given)

    def interrupted(what, done, total):
        if what == "simulation" and len(made) > 6:
            raise KeyboardInterrupt

    monkeypatch.setattr(fit, "window_slopes", counted)
    with pytest.raises(KeyboardInterrupt):
        identify(log, start, free=free, parts=parts, progress=interrupted)
    assert [path.name for path in parts.iterdir()] == ["simulation-so-far.json"]
    begun_with = len(made)
    made.clear()
    other = identify(log, begun(true, 1.1, ("lift.pilot.gain",)), free=free, parts=tmp_path / "others")
    whole = len(made)
    made.clear()
    found = identify(log, start, free=free, parts=parts)
    assert len(made) < whole - begun_with + 4
    assert not parts.exists()
    gain = [m.machine.function("lift").pilot.gain for m in (found, other)]
    assert gain[0] == pytest.approx(gain[1], rel=1e-3)
    assert gain[0] == pytest.approx(true.function("lift").pilot.gain, rel=5e-3)


def test_pilots_and_pump_from_commands_and_angles_alone(tmp_path):
    true = load_machine(NAME)
    log = commands_and_angles(operator_log(NAME, seconds=13.0))
    assert lacking_for_runs(true, log) == ""
    start = begun(true, 1.12, ("lift.pilot.gain", "work.pump.flow"))
    never = ["functions.lift.valve.hysteresis", "functions.lift.friction.sticks"]  # through simulation
    told = []
    found = identify(
        log, start, free=["functions.lift.pilot.gain", "*.pump.flow", *never], progress=lambda *step: told.append(step)
    )
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)
    assert all(done <= total for _, done, total in told)
    assert found.machine.function("lift").pilot.gain == pytest.approx(true.function("lift").pilot.gain, rel=5e-3)
    assert found.machine.circuit("work").pump.flow == pytest.approx(true.circuit("work").pump.flow, rel=5e-3)
    assert "simulation of" in found.changes["circuits.work.pump.flow"].source
    assert "circuits.work: not by regression; the log has no tilt.spool" in " ".join(found.kept)
    for path in never:
        assert [line for line in found.kept if line.startswith(f"{path}: kept; the log has no ")]
    text = str(found)
    assert "windows of 2 s against sensors" in text
    assert re.search(r"lift\.angle +\S+ deg +0\.02\d+ deg", text)
    page = tmp_path / "card.html"
    write_identification_card(found, page)
    assert "windows of 2 s against sensors" in page.read_text(encoding="utf-8")


def test_a_still_log_shows_no_number():
    true = load_machine(NAME)
    rows = 600
    still = {"time": 0.02 * np.arange(rows)}
    for f in true.functions:
        still |= {
            f"{f.name}.voltage": np.zeros(rows),
            f"{f.name}.angle": np.full(rows, 0.5 * (f.stops.low + f.stops.high)),
        }
    with pytest.raises(InputError, match="determines nothing of this machine.*no lever moves in the log"):
        identify(Table(still, {}), true, free=["functions.lift.pilot.gain"])


@pytest.mark.slow
def test_curves_pumps_and_pilots_of_an_excavator_from_commands_and_angles():
    """Inlets beyond where a valve is wide open hardly show; all else that is said to be known must be near."""
    true = load_machine("cat215b")
    log = commands_and_angles(operator_log("cat215b", seconds=150.0, seed=31))
    start = begun(true, 1.12, ("pilot.gain", "pilot.time_constant", "pump.flow"))
    found = identify(log, start)
    before = {n.path: n.value for n in true.numbers}
    for f in true.names:
        assert found.machine.function(f).pilot.gain == pytest.approx(before[f"functions.{f}.pilot.gain"], rel=5e-3)
    for c in true.circuits:
        assert found.machine.circuit(c.name).pump.flow == pytest.approx(c.pump.flow, rel=5e-3)
    sharp = [e for e in found.runs.estimates.numbers if e.sd < 0.02 * e.value]
    assert len(sharp) >= 12
    assert all(abs(e.value - before[e.path]) < 0.1 * before[e.path] for e in sharp)
