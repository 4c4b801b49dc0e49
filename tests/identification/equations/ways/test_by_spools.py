"""Pilots and what spools do besides: found where it is, none where it is not, and named where nobody asked."""

import pytest

from helpers.lagging_log import LAG, SPRING, lagging_log
from helpers.machine_log import machine_log
from polydraulic import InputError, load_machine
from polydraulic.identification import identify
from polydraulic.identification.equations.free_numbers import Freedom, entries_of
from polydraulic.identification.equations.pilot_fit import PilotFit, told_dead_time
from polydraulic.identification.equations.ways.by_spools import _pilot_changes, _unlike_a_run
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.tables import Table

MACHINE = load_machine("cat215b")
FREE = Freedom(dict.fromkeys(entries_of(MACHINE), float("nan")), False)
PILOTS = ["functions.boom.pilot.*"]
PLAY, FORCE = "functions.boom.valve.hysteresis", "functions.boom.valve.flow_force.spring_rate"


def test_a_hysteresis_and_a_flow_force_are_found_with_the_pilot():
    found = identify(lagging_log(), MACHINE, free=[*PILOTS, PLAY, FORCE])
    lag, spring, gain = (found.changes[path] for path in (PLAY, FORCE, "functions.boom.pilot.gain"))
    assert abs(lag.value - LAG) < min(3.0 * lag.uncertainty, 0.05 * LAG)
    assert abs(spring.value - SPRING.spring_rate) < min(3.0 * spring.uncertainty, 0.02 * SPRING.spring_rate)
    assert abs(gain.value / MACHINE.function("boom").pilot.gain - 1.0) < 2e-3
    effects = found.machine.function("boom").effects
    assert effects.hysteresis == lag.value
    assert effects.flow_force == SPRING._replace(spring_rate=spring.value)
    assert not any(found.machine.function(name).effects.declared for name in ("swing", "stick"))
    assert f"{PLAY}  " in str(found)
    assert " none " in str(found)


def test_what_was_found_is_written_and_read(tmp_path):
    found, path = identify(lagging_log(), MACHINE, free=[*PILOTS, PLAY, FORCE]), tmp_path / "found.toml"
    found.write(path)
    again = load_machine(path).function("boom").effects
    assert again.hysteresis == pytest.approx(found.machine.function("boom").effects.hysteresis, rel=1e-8)
    assert again.flow_force == pytest.approx(found.machine.function("boom").effects.flow_force, rel=1e-8)
    # declared now, they are free where nothing is said
    more = identify(lagging_log(), path)
    assert more.changes[PLAY].value == pytest.approx(found.changes[PLAY].value, rel=0.02)
    assert more.changes[FORCE].value == pytest.approx(found.changes[FORCE].value, rel=0.02)


def test_what_shows_and_nobody_asked_for_is_named():
    found = identify(lagging_log(), MACHINE, free=PILOTS)
    assert not found.machine.function("boom").effects.declared
    assert (
        f"the spool of boom lags behind its pilot by about 0.3 mm, of which the machine knows nothing: free {PLAY}"
        in [line.replace("0.29 mm", "0.3 mm").replace("0.31 mm", "0.3 mm") for line in found.remarks]
    )
    (force,) = (line for line in found.remarks if line.endswith(f"of which the machine knows nothing: free {FORCE}"))
    assert force.startswith("jets push the spool of boom back, against a spring of about ")


def test_a_spool_that_follows_its_pilot_has_no_effects():
    log = machine_log(120.0)
    found = identify(
        log,
        MACHINE,
        free=["functions.*.pilot.*", "functions.*.valve.hysteresis", "functions.*.valve.flow_force.spring_rate"],
    )
    assert not any(f.effects.declared for f in found.machine.functions)
    assert not [path for path in found.changes if ".valve." in path]
    for name in MACHINE.names:
        assert [line for line in found.kept if line.startswith(f"functions.{name}.valve.hysteresis: none; ")]
        assert [line for line in found.kept if line.startswith(f"functions.{name}.valve.flow_force: none; ")]
    assert not [
        line for line in identify(log, MACHINE, free=PILOTS).remarks if "of which the machine knows nothing" in line
    ]


def test_declared_effects_that_are_not_there_are_none():
    declared = MACHINE._replace(
        functions=tuple(
            f._replace(effects=f.effects._replace(hysteresis=2e-4, flow_force=SPRING)) for f in MACHINE.functions
        )
    )
    found = identify(machine_log(120.0), declared, free=[*PILOTS, PLAY, FORCE])
    assert found.machine.function("boom").effects == MACHINE.function("boom").effects._replace(hysteresis=0.0)
    assert found.machine.function("swing").effects == declared.function("swing").effects


def test_sensors_that_do_not_tell_are_named():
    log = lagging_log()

    def without(*names):
        return Table({name: log[name] for name in log.names if name not in names}, log.units)

    with pytest.raises(InputError, match=f"{PLAY}: kept; the log has no voltage with a spool that follows it"):
        identify(without("boom.spool"), MACHINE, free=[PLAY])
    with pytest.raises(InputError, match=f"{FORCE}: kept; the log has no boom.p_a, boom.p_b"):
        identify(without("boom.p_a", "boom.p_b"), MACHINE, free=[FORCE])
    found = identify(without("boom.p_a", "boom.p_b"), MACHINE, free=[PLAY])
    (doubt,) = (line for line in found.remarks if line.startswith(PLAY))
    assert "has not the pressures of its circuit" in doubt


@pytest.mark.parametrize(("rate", "named"), [(1e5, False), (1e3, True)])
def test_a_force_that_steps_cannot_follow_is_named(rate, named):
    so_far = SoFar(MACHINE, FREE, "")
    so_far.declare("boom", flow_force=SPRING._replace(spring_rate=rate))
    told = _unlike_a_run(so_far, "boom", "shift", None)
    assert len(told) == named
    assert all("functions.boom.valve.flow_force" in line and "steps of 0.005 s can follow" in line for line in told)


@pytest.mark.parametrize(
    ("late", "error", "dead"),
    [(0.0101, 0.0033, 0.0101), (0.0098, 0.0033, 0.0), (1.01e-3, 1e-5, 1.01e-3), (0.99e-3, 1e-5, 0.0)],
)
def test_a_dead_time_is_three_standard_errors_and_a_millisecond(late, error, dead):
    """What is less is a little more of the lag; 2.5 ms are the step's, which a run adds to each."""
    assert told_dead_time(late, error) == dead
    f = MACHINE.function("boom")
    pilot, errors = f.pilot._replace(dead_time=late + 2.5e-3), f.pilot._replace(dead_time=error)
    changes = _pilot_changes(f, PilotFit(pilot, errors, 1e-5, 700), FREE, "log.csv")
    assert changes["functions.boom.pilot.dead_time"].value == pytest.approx(dead)
    assert changes["functions.boom.pilot.time_constant"].value == pytest.approx(pilot.time_constant + late - dead)
