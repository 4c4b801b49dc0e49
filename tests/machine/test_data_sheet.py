"""What `machine check` sets next to a data sheet, against runs of the machine and hand calculations."""

import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import Simulator, load_machine
from polydraulic.machine.data_sheet import doubtful_statics, function_sheets, sheet_lines
from polydraulic.parameters.load import machine_names


def test_volumes_over_flow_are_the_times_of_a_motor_and_a_cylinder():
    crane = load_machine("loader_crane")
    sheets = function_sheets(crane)
    slew, reach = crane.function("slew"), crane.function("reach")
    turn = 2.0 * np.pi * slew.drive.displacement * slew.drive.gear_ratio / crane.circuit("slew_and_reach").pump.flow
    assert sheets["slew"].to_high == pytest.approx(turn, rel=1e-12)
    area = np.pi / 4.0 * reach.drive.bore**2
    assert sheets["reach"].stroke == pytest.approx(reach.stops.high - reach.stops.low, rel=1e-12)
    assert sheets["reach"].to_high == pytest.approx(
        area * sheets["reach"].stroke / crane.circuit("slew_and_reach").pump.flow, rel=1e-12
    )


def test_the_pressures_that_hold_a_machine_hold_it_in_a_run():
    machine = load_machine("cat215b")
    sheets = function_sheets(machine)
    held = machine.with_values(
        {f"functions.{name}.initial.{port}": getattr(sheet, f"hold_{port[-1]}") for name, sheet in sheets.items() for port in ("p_a", "p_b")}
    )  # fmt: skip
    with Simulator(held) as stands:
        stands.step({}, n=100)
        for f in held.functions:
            assert float(stands[f"{f.name}.angle"]) == pytest.approx(f.initial.angle, abs=2e-4)  # rad


@pytest.mark.parametrize("name", machine_names())
def test_machines_of_the_package_stand_and_begin_without_a_jolt(name):
    machine = load_machine(name)
    assert list(doubtful_statics(machine)) == []
    assert len(sheet_lines(machine)) == len(machine.functions)


def test_a_relief_valve_below_the_load_and_a_jolt_are_named(tmp_path):
    sinks = load_machine(write_crane(tmp_path, 'mass = {value = 250, unit = "kg"', 'mass = {value = 25, unit = "t"'))
    assert any("so that it sinks; check masses" in line for line in doubtful_statics(sinks))
    good = load_machine(write_crane(tmp_path))
    jolt = good.with_values({"functions.lift.initial.p_a": 1.5e7, "functions.lift.initial.p_b": 5e5})
    (line,) = (line for line in doubtful_statics(jolt) if line.startswith("functions.lift"))
    assert line.startswith("functions.lift.initial: p_a = 150 bar and p_b = 5 bar do not hold it, ")
    assert line.endswith("it begins with a jolt")
