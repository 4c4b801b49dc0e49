from helpers.small_crane import write_crane, write_crossover_crane
from polydraulic import load_machine
from polydraulic.parameters.layout.describe import described


def test_a_person_sees_what_hangs_where_and_who_is_fed_by_whom(tmp_path):
    lines = described(load_machine(write_crane(tmp_path)))
    assert "  boom: revolute about -y on column, 250 kg" in lines
    assert "  arm: prismatic along x on boom, 120 kg" in lines
    assert "  extend: a cylinder along its joint on arm, 0 mm to 1400 mm" in lines
    assert "  main: 40 l/min, relief 250 bar, torque limit from 120 bar; feeds slew, then lift" in lines
    lift = next(line for line in lines if line.startswith("  lift:"))
    assert "-20 deg to 70 deg" in lift
    assert lift.count(" mm") == 3


def test_a_crossover_is_said_to_lead_from_one_pump_to_a_valve_of_the_other(tmp_path):
    lines = described(load_machine(write_crossover_crane(tmp_path)))
    assert "  main_taking: 40 l/min, relief 250 bar, torque limit from 120 bar; feeds slew, then lift" in lines
    assert "  main: crossover from main_giving to before lift, at most 37.95 l/min at 10 bar, opens at 1.5 bar" in lines
