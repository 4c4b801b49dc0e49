import pytest

from polydraulic import InputError, load_machine
from polydraulic.identification.equations.free_numbers import entries_of, fitted_here, freedom
from polydraulic.parameters.entries import read_toml
from polydraulic.parameters.load import machine_path, machine_text


@pytest.fixture(scope="module")
def loader():
    return load_machine("wheel_loader")


def test_all_that_can_be_fitted_is_free_if_nothing_is_said(loader):
    found = freedom(loader, read_toml(machine_path("wheel_loader")), [])
    assert not found.marked
    assert set(found.spreads) == {path for path in entries_of(loader) if fitted_here(path)}
    assert not found.has("gravity")


def test_pumps_that_a_crossover_joins_can_be_fitted_as_others_can():
    machine = load_machine("cat215b_crossover")
    found = freedom(machine, {}, [])
    assert {f"{c.pump_path}.flow" for c in machine.circuits} <= set(found.spreads)


def test_patterns_choose_paths(loader):
    name = loader.names[0]
    found = freedom(loader, {}, [f"functions.{name}.valve.*", "gravity"])
    assert found.marked
    assert found.has(f"functions.{name}.valve.inlet")
    assert found.has("gravity")
    assert not found.has(f"functions.{name}.pilot.gain")
    with pytest.raises(InputError, match="--free 'links.none.mass' fits no number of the machine"):
        freedom(loader, {}, ["links.none.mass"])
    with pytest.raises(InputError, match=f"near it: functions.{name}.valve.inlet, "):
        freedom(loader, {}, [f"functions.{name}.valve.inlte"])
    with pytest.raises(InputError, match="'zzz' fits no number of the machine; paths are such as gravity, "):
        freedom(loader, {}, ["zzz"])


@pytest.mark.parametrize(
    ("misspelt", "meant"),
    [
        ("friction.stick", "friction.sticks"),
        ("valve.hysteresys", "valve.hysteresis"),
        ("valve.flow_force", "valve.flow_force.spring_rate"),
    ],
)
def test_what_a_file_need_not_declare_is_near_as_well(loader, misspelt, meant):
    name = loader.names[0]
    with pytest.raises(InputError, match=f"near it: functions.{name}.{meant}"):
        freedom(loader, {}, [f"functions.{name}.{misspelt}"])


def test_a_file_marks_what_is_free_with_its_spread(loader, tmp_path):
    text = machine_text("wheel_loader").replace("flow = { value =", "flow = { free = true, spread = 6.0, value =", 1)
    path = tmp_path / "free.toml"
    path.write_text(text, encoding="utf-8")
    assert load_machine(path) == loader
    data = read_toml(path)
    found = freedom(loader, data, [])
    (marked,) = found.spreads
    assert marked.endswith(".pump.flow")
    circuit = loader.circuit(marked.split(".")[1])
    unit = data["circuits"][circuit.name]["pump"]["flow"]
    assert found.spread(marked, 0.0) == pytest.approx(6.0 * circuit.pump.flow / unit["value"])
    assert found.spread("gravity", 3.0) == 3.0


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("free = 1", "gravity.free = 1: must be true or false"),
        ("spread = -1.0", "gravity.spread = -1.0: must be a number above 0"),
        ("spread = inf", "gravity.spread = inf: must be a number above 0"),
        ("uncertainty = -1.0", "gravity.uncertainty = -1.0: must be 0 or more"),
        ('uncertainty = "x"', "gravity.uncertainty = 'x': must be 0 or more"),
        ("loose = true", "unknown key 'loose' in gravity"),
    ],
)
def test_marks_that_cannot_be_are_refused(tmp_path, more, words):
    path = tmp_path / "marked.toml"
    path.write_text(
        machine_text("wheel_loader").replace("gravity = {", "gravity = { " + more + ",", 1), encoding="utf-8"
    )
    with pytest.raises(InputError) as error:
        load_machine(path)
    assert words in str(error.value)


def test_effects_that_are_not_declared_are_free_where_a_pattern_ends_as_they_do(loader):
    name = loader.names[0]
    lag, spring = f"functions.{name}.valve.hysteresis", f"functions.{name}.valve.flow_force.spring_rate"
    assert set(freedom(loader, {}, ["functions.*.valve.hysteresis"]).spreads) == {
        f"functions.{other}.valve.hysteresis" for other in loader.names
    }
    assert set(freedom(loader, {}, [spring]).spreads) == {spring}
    assert not any(path in freedom(loader, {}, ["functions.*.valve.*"]).spreads for path in (lag, spring))
    with pytest.raises(InputError, match="'functions.none.valve.hysteresis' fits no number"):
        freedom(loader, {}, ["functions.none.valve.hysteresis"])
    f = loader.function(name)
    declared = f._replace(effects=f.effects._replace(hysteresis=1e-4))
    machine = loader._replace(functions=(declared, *loader.functions[1:]))
    assert freedom(machine, {}, ["functions.*.valve.*"]).has(lag)
    assert freedom(machine, {}, []).has(lag)
    assert not freedom(machine, {}, []).has(spring)
