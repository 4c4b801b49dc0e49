import pytest

from polydraulic.errors import InputError
from polydraulic.parameters.keys import check_keys


@pytest.mark.parametrize("data", [{"a": 1}, {"a": 1, "b": 2}])
def test_tables_with_what_they_need_are_taken(data):
    assert check_keys(data, {"a", "b"}, {"a"}) is None


@pytest.mark.parametrize(
    ("data", "where", "file", "message"),
    [
        ({"a": 1, "c": 3}, "", "", "unknown key 'c'; allowed here: ['a', 'b']"),
        ({"a": 1, "z": 3, "c": 3}, "sensor 3", "", "unknown key 'c' in sensor 3; allowed here: ['a', 'b']"),
        ({"b": 1}, "boom.pilot", "mine.toml", "mine.toml: missing key 'a' in boom.pilot; needed here: ['a']"),
        (5, "change", "mine.toml", "mine.toml: change must be a table, not 5"),
        ([], "", "", "file must be a table, not []"),
    ],
)
def test_others_are_named_with_what_is_allowed(data, where, file, message):
    with pytest.raises(InputError) as error:
        check_keys(data, {"b", "a"}, {"a"}, where, file)
    assert str(error.value) == message
