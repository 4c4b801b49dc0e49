"""Numbers of a machine come back from logs that lack most sensors."""

import numpy as np
import pytest

from helpers.operator_log import operator_log
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.equations.shooting import fit as fit_of_windows
from polydraulic.identification.equations.shooting.fit import fit_by_shooting
from polydraulic.parameters.layout.schema import position_columns
from polydraulic.tables import Table

NAME = "wheel_loader"
CURVES = ("inlet", "bypass", "outlet_positive", "outlet_negative")
FEW = {"functions.tilt.pilot.gain": 1.15, "functions.tilt.pilot.time_constant": 0.85, "links.bucket.mass": 1.2}


def begun(machine, factors):
    truth = {number.path: number.value for number in machine.numbers}
    values = {path: factor * truth[path] for path, factor in factors.items()}
    return machine.with_values(values), {path: 0.2 * truth[path] for path in factors}, truth


def test_pilot_and_payload_from_commands_and_angles_alone():
    machine = load_machine(NAME)
    prior, spreads, truth = begun(machine, FEW)
    told = []
    fit = fit_by_shooting(
        operator_log(NAME),
        prior,
        spreads,
        sensors=position_columns(machine),
        seconds=1.0,
        most=16,
        progress=lambda *args: told.append(args),
    )
    for path in FEW:
        number = fit.estimates.of(path)
        assert number.determined
        assert number.value == pytest.approx(truth[path], rel=0.02)
        assert abs(number.value - truth[path]) < 5.0 * number.sd
        assert dict((n.path, n.value) for n in fit.machine.numbers)[path] == number.value
    assert fit.noise["tilt.angle"] == pytest.approx(5e-4, rel=0.3)
    assert fit.before["tilt.angle"] > 2.0 * fit.noise["tilt.angle"]
    assert fit.settled
    assert told[-1][1] == told[-1][2]
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)


def test_positions_that_are_silent_at_times_of_their_own_tell_as_much_as_their_rows():
    machine, log = load_machine(NAME), operator_log(NAME)
    prior, spreads, truth = begun(machine, FEW)
    rng, columns = np.random.default_rng(2), dict(log.columns)
    for name in position_columns(machine):
        silent = np.convolve(rng.random(len(log)) < 0.006, np.ones(25))[: len(log)] > 0.0
        columns[name] = np.where(silent, np.nan, columns[name])
        assert 0.05 < silent.mean() < 0.3
    given = Table(columns, log.units).partial()
    fit = fit_by_shooting(given, prior, spreads, sensors=position_columns(machine), seconds=1.0, most=16)
    for path in FEW:
        number = fit.estimates.of(path)
        assert number.determined
        assert number.value == pytest.approx(truth[path], rel=0.03)
        assert abs(number.value - truth[path]) < 5.0 * number.sd


def test_an_unknown_sensor_and_an_unknown_number_are_refused():
    machine = load_machine(NAME)
    with pytest.raises(InputError, match="sensor 'tilt.flow' is no column"):
        fit_by_shooting(operator_log(NAME), machine, {"links.bucket.mass": 50.0}, sensors=["tilt.flow"])
    with pytest.raises(InputError, match="'links.bucket.weight': the machine has no such number"):
        fit_by_shooting(operator_log(NAME), machine, {"links.bucket.weight": 50.0})


@pytest.mark.slow
@pytest.mark.parametrize("name", ["loader_crane", "cat215b_bucket"])
def test_pilots_pumps_and_friction_from_two_minutes(name):
    machine, rng = load_machine(name), np.random.default_rng(2)
    ends = ("pilot.gain", "pilot.time_constant", "pump.flow", "friction.coulomb", "friction.viscous")
    factors = {n.path: float(np.exp(0.15 * rng.normal())) for n in machine.numbers if n.path.endswith(ends)}
    for f in machine.names:
        coulomb = f"functions.{f}.friction.coulomb"
        factors[coulomb.replace("coulomb", "static")] = max(1.0, factors[coulomb])
    prior, spreads, truth = begun(machine, factors)
    log = operator_log(name, seconds=130.0, seed=8)
    fit = fit_by_shooting(log, prior, spreads, sensors=position_columns(machine), most=64)
    for number in fit.estimates.numbers:
        allowed = 0.01 if number.path.endswith(ends[:3]) else 0.15
        assert number.value == pytest.approx(truth[number.path], rel=allowed), number.path


@pytest.mark.slow
def test_all_curves_from_pressures_and_angles_are_off_by_no_more_than_they_say():
    """An inlet that begins a third too wide shuts on the way between two knots, and has to open again."""
    machine, off = (
        load_machine(NAME),
        dict(zip(CURVES, (1.3, 0.8, 1.3, 0.7), strict=True)) | {"gain": 1.1, "flow": 1.05},
    )
    kinds = {number.path: number.path.partition("[")[0].rpartition(".")[2] for number in machine.numbers}
    prior, spreads, truth = begun(machine, {path: off[kind] for path, kind in kinds.items() if kind in off})
    spreads = {path: 1.5 * off[kinds[path]] * spread for path, spread in spreads.items() if spread > 0.0}
    sensors = [*position_columns(machine), *(f"{name}.{port}" for name in machine.names for port in ("p_a", "p_b"))]
    fit = fit_by_shooting(
        operator_log(NAME, seconds=130.0, seed=7), prior, spreads, sensors=sensors, seconds=2.0, most=64
    )
    assert fit.settled
    for number in fit.estimates.numbers:
        if number.determined:
            assert abs(number.value - truth[number.path]) < 5.0 * number.sd, number.path
            assert number.value == pytest.approx(truth[number.path], rel=0.05), number.path


def test_a_search_that_may_make_no_more_steps_says_so(monkeypatch):
    machine = load_machine(NAME)
    prior, spreads, _ = begun(machine, FEW)
    monkeypatch.setattr(fit_of_windows, "_PASSES", ((1.0, 1),))
    found = fit_by_shooting(operator_log(NAME), prior, spreads, sensors=position_columns(machine), seconds=1.0, most=16)
    assert not found.settled
