from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.parameters.layout.schema import position_column, position_columns


def test_the_column_of_a_joint_goes_by_its_kind(tmp_path):
    assert position_columns(load_machine("cat215b")) == ["swing.angle", "boom.angle", "stick.angle"]
    crane = load_machine(write_crane(tmp_path))
    assert position_columns(crane) == ["slew.angle", "lift.angle", "extend.position"]
    assert position_column(crane, crane.function("extend")) == "extend.position"
