from polydraulic.measure.formats.log import Signal
from polydraulic.measure.formats.named import GroupName, in_groups


def test_names_that_come_once_are_plain_and_all_go_by_their_group():
    found = [Signal("p", "bar", 0), Signal("x", "mm", 0), Signal("p", "psi", 1)]
    named = in_groups(found, [GroupName("fast", ("first",)), GroupName("slow")])
    assert [signal[:3] for signal in named.signals] == [("p", "bar", 0), ("x", "mm", 0), ("slow/p", "psi", 1)]
    assert named.duplicates == ["p"]
    for name, place in (("p", 0), ("fast/p", 0), ("first/x", 1), ("0/x", 1), ("slow/p", 2), ("1/p", 2)):
        assert named.origin[name] == place
    assert named.also["fast/p"] == found[0]
    assert named.also["1/p"].group == 1


def test_groups_of_one_name_and_names_that_come_twice_in_a_group_are_told_apart():
    found = [Signal("p", "", 0), Signal("p", "", 1), Signal("p", "", 1), Signal("CAN 1/p", "", 2)]
    named = in_groups(found, [GroupName("CAN"), GroupName("CAN"), GroupName("other")])
    names = [signal.name for signal in named.signals]
    assert names == ["p", "CAN 1/p[2]", "CAN 1/p[3]", "CAN 1/p"]
    assert [named.origin[name] for name in names] == [0, 1, 2, 3]
