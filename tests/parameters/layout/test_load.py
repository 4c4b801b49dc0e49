"""Machine files with links, functions and circuits: what is read, and what is refused all at once."""

import math

import pytest

from helpers.small_crane import crane_text, write_crane, write_crossover_crane
from polydraulic import InputError, load_machine
from polydraulic.parameters.load import machine_names


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


def refused(folder, old, new):
    with pytest.raises(InputError) as error:
        load_machine(write_crane(folder, old, new))
    return str(error.value)


def test_numbers_arrive_in_si_whatever_unit_they_were_written_in(crane):
    assert crane.circuits[1].pump.flow == pytest.approx(20 * 3.785411784e-3 / 60)
    assert crane.function("slew").drive.displacement == pytest.approx(80e-6 / (2 * math.pi))
    assert crane.function("extend").friction.viscous == 1500.0  # N s/m
    assert crane.function("lift").stops.high == pytest.approx(math.radians(70))
    assert crane.link("boom").at == {"x": 0.1, "z": 1.5}


def test_a_function_has_the_role_that_the_file_gives_or_that_its_name_is(tmp_path):
    path = write_crane(tmp_path, 'actuator = "ram"', 'actuator = "ram"\nrole = "extension"')
    assert [f.role for f in load_machine(path).functions] == ["", "", "extension"]
    assert [f.role for f in load_machine("cat215b").functions] == ["swing", "boom", "stick"]


def test_functions_stand_in_the_order_of_their_links(tmp_path):
    text = crane_text()
    first, last = text.index("[functions.slew]"), text.index("[functions.extend]")
    end = text.index("[circuits.main]")
    path = tmp_path / "turned.toml"
    path.write_text(text[:first] + text[last:end] + text[first:last] + text[end:], encoding="utf-8")
    assert load_machine(path).names == ("slew", "lift", "extend")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('parent = "column"', 'parent = "colum"', "links.boom.parent = 'colum': must be one of ['ground', 'column'"),
        ('parent = "ground"', 'parent = "arm"', "form a loop"),
        ("[links.column]", "[links.class]", "'class' is a word of Python"),
        ("[functions.slew]", "[functions.int]", "'int' is a word of C or C++"),
        ("[functions.slew]", '[functions."a-b"]', "must be 1 to 40 ASCII letters"),
        ('moves = "arm"', 'moves = "boom"', "functions.extend.actuator = 'ram': cannot move boom, whose joint is revolute"),
        ('actuator = "ram"', 'actuator = "ram"\nrole = "arm"', "functions.extend.role = 'arm': must be one of ['swing', 'boom', 'stick'"),
        ('actuator = "ram"', 'actuator = "cylinder"', "cannot move arm, whose joint is prismatic"),
        ('functions = ["extend"]', 'functions = ["extend", "slew"]', "functions.slew: appears 2 times in the circuits"),
        ('functions = ["extend"]', 'functions = ["stretch"]', "'stretch' is not a function"),
        ('axis = "-y"', 'axis = "up"', "links.boom.axis = 'up': must be one of ['x', 'y', 'z'"),
        ("mass = {value = 250", "mass = {value = -250", "links.boom.mass = -250 kg: must be 0 kg or more"),
        ('at.z = {value = 1.5, unit = "m"', 'at.z = {value = 1.5, unit = "kg"', "links.boom.at.z has unit 'kg'"),
        ("at.z = {", "at.w = {", "unknown key 'w' in links.boom.at"),
        ("value = [0, 1, 4, 8]", "value = [0, 4, 1, 8]", "functions.slew.valve.knots"),
        ("value = [30, 14, 2, 0]", "value = [30, 14, 2]", "functions.slew.valve.bypass: 3 numbers for 4 knots"),
        ("initial.angle = {value = 20", "initial.angle = {value = 95", "initial.angle = 95 deg: must be within the stops, -20 deg to 70 deg"),
        ("rod_pin.x = {value = 0.7", "rod_pin.x = {value = -0.1", "functions.lift"),
        ("inertia.zz = {value = 161", "inertia.zz = {value = 400", "no body has one above the sum of the others"),
        ("pump.relief = {value = 250", "pump.relief = {value = 2", "pump.relief = 2 bar: must be above tank.return_pressure = 3 bar"),
        ("number = {value = 1, ", "number = {value = 1.5, ", "functions.lift.cylinder.number = 1.5: must be a whole number"),
        ('kind = "series"', 'kind = "parallel"', "circuits.main.kind = 'parallel': must be one of ['series', 'crossover']"),
        ('link = "arm"', 'link = "hook"', "tip.link = 'hook'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_what_is_allowed(tmp_path, old, new, words):
    assert words in refused(tmp_path, old, new)


def test_a_loop_is_named_once_with_the_links_that_form_it(tmp_path):
    """And not what hangs on it, nor that nothing is left for functions and tip to name."""
    text = refused(tmp_path, 'parent = "ground"', 'parent = "boom"')
    loop = "'ground' must be above every link"
    assert text.splitlines()[1:] == [
        f"  links.column.parent = 'boom': column, boom form a loop; {loop}",
        f"  links.boom.parent = 'column': boom, column form a loop; {loop}",
    ]
    own = refused(tmp_path, 'parent = "ground"', 'parent = "column"')
    assert own.endswith(f"links.column.parent = 'column': a link is not its own parent; {loop}")


def test_links_below_one_whose_parent_is_misspelt_are_good(tmp_path):
    assert refused(tmp_path, 'parent = "ground"', 'parent = "grund"').endswith(
        "crane.toml: links.column.parent = 'grund': must be one of ['ground', 'boom', 'arm']"
    )


@pytest.mark.parametrize(("actuator", "misspelt"), [("cylinder", "cylindre"), ("ram", "rams"), ("motor", "moter")])
def test_what_a_function_of_a_misspelt_actuator_has_is_not_said_to_be_wrong(tmp_path, actuator, misspelt):
    text = refused(tmp_path, f'actuator = "{actuator}"', f'actuator = "{misspelt}"')
    assert text.endswith(f".actuator = {misspelt!r}: must be one of ['motor', 'cylinder', 'four_bar', 'ram']")


@pytest.mark.parametrize("table", ["links", "functions"])
def test_where_a_table_is_misspelt_nothing_is_offered_to_choose_from(tmp_path, table):
    path = tmp_path / "misspelt.toml"
    path.write_text(crane_text().replace(f"[{table}.", f"[{table}z."), encoding="utf-8")
    with pytest.raises(InputError, match=f"unknown key '{table}z'; allowed here") as error:
        load_machine(path)
    assert "[]" not in str(error.value)


def test_a_crossover_is_two_circuits_and_a_valve_between_them(tmp_path):
    machine = load_machine(write_crossover_crane(tmp_path))
    assert [(c.name, c.functions, c.pump_path) for c in machine.circuits] == [
        ("main_giving", ("extend",), "circuits.main.giving"),
        ("main_taking", ("slew", "lift"), "circuits.main.taking"),
    ]
    (x,) = machine.crossovers
    assert (x.name, x.giving, x.taking) == ("main", "main_giving", "main_taking")
    assert x.valve.conductance[3] == pytest.approx(12e-3 / 60 / 1e5**0.5)
    assert x.valve.opening_pressure == pytest.approx(1.5e5)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"extend", "slew", "lift"', '"slew", "lift"', "circuits.main.functions = ['slew', 'lift']: must be a list of 3 to 4 names"),
        ("giving.flow = {value = 20", "giving.flow = {value = -20", "circuits.main.giving.flow = -20 gpm"),
        ("giving.relief = {value = 250", "giving.relief = {value = 2", "circuits.main.giving.relief = 2 bar: must be above"),
        ("value = [0, 1, 6, 12]", "value = [0, 1, 6]", "circuits.main.crossover.conductance: 3 numbers for the 4 knots of functions.lift.valve"),
        ("value = [0, 1, 6, 12]", "value = [0, -1, 6, 12]", "circuits.main.crossover.conductance"),
        ("crossover.opening_pressure", "crossover.cracking", "unknown key 'cracking' in circuits.main.crossover"),
        ("taking.flow", "pump.flow", "unknown key 'pump' in circuits.main"),
        ("[circuits.main]", "[circuits.class]", "'class' is a word of Python"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_crossover_is_named(tmp_path, old, new, words):
    with pytest.raises(InputError) as error:
        load_machine(write_crossover_crane(tmp_path, old, new))
    assert words in str(error.value)


def test_a_circuit_may_not_be_called_as_a_pump_of_another(tmp_path):
    path = write_crossover_crane(tmp_path, '"extend", "slew"', '"extend", "extend", "slew"')
    text = path.read_text(encoding="utf-8")
    second = crane_text()
    path.write_text(
        text + second[second.index("[circuits.second]") :].replace("second", "main_giving"), encoding="utf-8"
    )
    with pytest.raises(
        InputError, match="circuits: 'main_giving' is what a pump of a circuit with crossover is called"
    ):
        load_machine(path)


def test_all_that_is_wrong_is_said_at_once(tmp_path):
    text = crane_text().replace('axis = "-y"', 'axis = "up"').replace("value = 80, unit", "value = -80, unit")
    path = tmp_path / "wrong.toml"
    path.write_text(text.replace('title = "Small crane"', "title = 3"), encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_machine(path)
    found = str(error.value).split("\n  ")
    assert found[0] == f"{path}: what is wrong:"
    assert [line.split(" ")[0] for line in found[1:]] == [
        "title",
        "links.boom.axis",
        "functions.slew.motor.displacement",
    ]


def test_a_name_written_twice_but_for_capitals_is_refused(tmp_path):
    text = (
        crane_text()
        .replace("[links.arm]", "[links.BOOM]")
        .replace('moves = "arm"', 'moves = "BOOM"')
        .replace('link = "arm"', 'link = "BOOM"')
    )
    path = tmp_path / "twice.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="appears twice, but for upper and lower case"):
        load_machine(path)


def test_more_links_than_there_may_be_are_refused(tmp_path):
    text = crane_text()
    arm = text[text.index("[links.arm]") : text.index("[functions.slew]")]
    more = "".join(arm.replace("[links.arm]", f"[links.arm{k}]") for k in range(11))
    path = tmp_path / "many.toml"
    path.write_text(text.replace(arm, arm + more), encoding="utf-8")
    with pytest.raises(InputError, match="links: 14 of them; must be 1 to 12"):
        load_machine(path)


@pytest.mark.parametrize("name", machine_names())
def test_every_machine_of_the_package_loads(name):
    assert load_machine(name)
