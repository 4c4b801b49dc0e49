from polydraulic.export.translate.names import Names, field_name, local_name


def test_names_are_those_of_python_unless_private_taken_or_reserved():
    names = Names()
    assert names.of("a", "line_step", "pkg.hose") == "line_step"
    assert names.of("b", "_outlet", "pkg.loop") == "loop_outlet"
    assert names.of("c", "line_step", "pkg.other") == "other_line_step"
    assert names.of("d", "exp", "pkg.elementary") == "elementary_exp"
    assert names.of("e", "_LIMIT", "pkg.pump") == "PUMP_LIMIT"
    assert names.of("f", "_Line", "pkg.right_hand") == "RightHandLine"


def test_a_thing_keeps_its_name_and_no_two_share_one():
    names = Names()
    given = [names.of(key, "f", "pkg.m") for key in range(4)]
    assert given == ["f", "m_f", "m_f_2", "m_f_3"]
    assert names.of(2, "g", "elsewhere") == "m_f_2"
    names.forget(1)
    assert names.of(9, "f", "pkg.m") == "m_f"


def test_names_from_outside_are_kept_free():
    names = Names()
    assert names.reserve("own", "machine_step") == "machine_step"
    assert names.of("kernel", "machine_step", "pkg.step") == "step_machine_step"


def test_fields_may_be_called_as_functions_of_c_and_variables_may_not():
    assert (field_name("exp"), field_name("static")) == ("exp", "static_")
    assert (local_name("exp"), local_name("static"), local_name("x")) == ("exp_", "static_", "x")
