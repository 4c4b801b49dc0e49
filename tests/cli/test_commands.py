"""The command line as a user meets it."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from polydraulic import load_models, save_models
from polydraulic.networks import Model, Network, Variable
from polydraulic.parameters.scenario import scenario_names
from polydraulic.tables import Table, read_table, write_table


def test_simulate_writes_a_run_and_a_picture(call, tmp_path):
    code, out, _ = call(
        "simulate", "single_05", "--flow", "polynomial", "--out", tmp_path / "r.parquet", "--plot", tmp_path / "r.svg"
    )
    assert code == 0
    assert "2000 steps of 0.005 s with flow 'polynomial'; 10 s computed in " in out
    assert len(read_table(tmp_path / "r.parquet")) == 2001
    assert (tmp_path / "r.svg").read_text().startswith("<?xml")
    largest = float(re.search(r"boom.angle\s+(\S+)", out)[1])
    assert abs(largest) < 0.15


def test_simulate_does_not_write_over_a_table_of_its_scenario(call, tmp_path):
    recorded = "t,v\n0,0\n1,0.5\n"
    (tmp_path / "rec.csv").write_text(recorded)
    (tmp_path / "sc.toml").write_text(
        'title = "a"\nsource = "b"\nduration = { value = 1.0, unit = "s", source = "b" }\n[voltage.boom]\nkind = "table"\n'
        'file = "rec.csv"\ntime_column = "t"\nvoltage_column = "v"\n'
    )
    code, _, error = call("simulate", tmp_path / "sc.toml", "--out", tmp_path / "rec.csv")
    assert (code, "rec.csv: is the file that is read, which would be replaced" in error) == (2, True)
    assert (tmp_path / "rec.csv").read_text() == recorded


def test_simulate_states_differences_of_all_links_and_the_tip(call, tmp_path):
    (tmp_path / "hand.csv").write_text("time,swing,boom,stick\n0,0.5,0.5,0.5\n0.5,0.5,0.4,0.6\n")
    code, out, _ = call(
        "simulate", tmp_path / "hand.csv", "--flow", "iterative", "--raster", 0.05, "--out", tmp_path / "r.csv"
    )
    assert code == 0
    assert "hand on cat215b: Recording of 0.5 s" in out
    _, _, table = out.partition("differences from exact:")
    named = [row for row in re.findall(r"^  (\S+) .* (\S+)$", table, re.MULTILINE) if row[0] != "largest"]
    links = [(f"{n}.{q}", u) for n in ("swing", "boom", "stick") for q, u in zip(
        ("angle", "rate", "q_in", "p_in"), ("deg", "deg/s", "l/min", "bar"), strict=True)]  # fmt: skip
    assert named == [*links, ("boom.p_pump", "bar"), ("series.p_pump", "bar"), ("tip", "mm")]
    assert read_table(tmp_path / "r.csv")["time"] == pytest.approx(np.arange(11) * 0.05)


def test_simulate_ends_with_a_summary_in_the_units_asked_for(call):
    code, out, err = call("simulate", "single_08", "--units", "field")
    assert (code, err) == (0, "")
    assert re.search(r"^largest pressures: boom \w [\d.]+ psi at [\d.]+ s, boom pump [\d.]+ psi at", out, re.MULTILINE)
    assert re.search(r"^  valve opens +boom \d+x from [\d.]+ s$", out, re.MULTILINE)
    assert re.search(r"^at the end: swing .* deg, .*; tip at x [\d.]+ in", out, re.MULTILINE)
    assert re.search(r"10 s computed in \S+ s, \S+ times as fast as real time", out)


def test_scenarios_are_listed_and_named_in_the_help(call):
    code, out, _ = call("scenarios")
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()] == [*scenario_names(), "random:SEED"]
    assert re.search(r"single_08 +10 s +cat215b +boom +Boom alone", out)
    assert len({re.search(r" s  \S", line).start() for line in out.splitlines()}) == 1
    assert all(name in call("simulate", "--help")[1] for name in scenario_names())


def test_animate_writes_a_page(call, tmp_path):
    code, out, _ = call(
        "animate", "random:1:0.5", "--flow", "exact", "--flow", "iterative", "--out", tmp_path / "run.html"
    )
    assert code == 0
    assert "run.html: random:1, exact, iterative" in out
    assert '"iterative"' in (tmp_path / "run.html").read_text()


def test_a_machine_of_any_layout_is_simulated_plotted_and_animated(call, tmp_path):
    chosen = ("random:3:0.5", "--machine", "wheel_loader", "--units", "field")
    files = ("--plot", tmp_path / "run.svg", "--out", tmp_path / "run.csv")
    code, out, _ = call("simulate", *chosen, "--forces", *files)
    assert code == 0
    assert re.search(r"tilt [AB] [\d.]+ psi at .* work pump [\d.]+ psi", out)
    assert re.search(r"at the end: lift .* tilt -?[\d.]+ deg; tip at x [\d.]+ in", out)
    assert (tmp_path / "run.svg").stat().st_size > 10_000
    header = (tmp_path / "run.csv").read_text().partition("\n")[0]
    assert "tilt.angle" in header
    assert "tilt.cylinder_force [N]" in header
    assert "lift.pin_moment_z [N m]" in header
    code, _, _ = call("animate", *chosen, "--out", tmp_path / "run.html")
    assert code == 0
    assert '"group":"tilt","title":"inlet pressure","unit":"psi"' in (tmp_path / "run.html").read_text()
    crossing = ("random:3:0.5", "--machine", "cat215b_crossover", "--flow", "stiff")
    code, _, error = call("simulate", *crossing, "--plot", tmp_path / "other.svg")
    assert code == 2
    assert "circuit 'main_giving' is of the kind 'crossover': use 'exact'" in error
    assert not (tmp_path / "other.svg").exists()


@pytest.mark.parametrize("machine", ["cat215b", "loader_crane", "wheel_loader"])
def test_a_machine_is_drawn(call, tmp_path, machine):
    code, out, _ = call("machine", "draw", machine, "--out", tmp_path / "machine.svg")
    assert code == 0
    assert "machine.svg" in out
    assert (tmp_path / "machine.svg").read_text().count("<path") > 100


@pytest.mark.slow
def test_simulate_takes_a_method(call):
    chosen = ("random:1:1", "--machine", "wheel_loader", "--method")
    code, out, _ = call("simulate", *chosen, "rosenbrock", "--raster", "0.1")
    assert code == 0
    assert "rosenbrock with flow 'exact' to a relative tolerance of 0.0001" in out
    code, _, error = call("simulate", *chosen, "euler")
    assert code == 2
    assert "unknown method 'euler'" in error


def test_sample_fit_export(call, tmp_path):
    table, model = tmp_path / "boom.parquet", tmp_path / "q.json"
    assert call("sample", "--circuit", "boom", "--rows", 300, "--out", table)[0] == 0
    code, out, _ = call(
        "fit", table, "--inputs", "boom.travel,boom.p_in", "--outputs", "boom.q_in,boom.p_pump", "--out", model,
        "--edges", "boom.travel=0.0047752,0.0095504", "--layers", 2, "--bounds", "0,1e8", "--prior", "half-variance",
    )  # fmt: skip
    assert code == 0
    assert out.count("held-out R2") == 2
    assert [str(m.output) for m in load_models(model)] == ["boom.q_in [m3/s]", "boom.p_pump [Pa]"]
    code, out, _ = call("export", model, "--to", "c", "--out", tmp_path / "of boom")
    assert code == 0
    assert sorted(p.name for p in (tmp_path / "of boom").iterdir()) == ["q.c", "q.h"]
    assert "q.c" in out
    assert "note: names: boom.travel is boom_travel" in out
    assert f"gcc -std=c99 -DQ_SELF_TEST '{tmp_path / 'of boom' / 'q.c'}' -lm" in out
    code, out, _ = call("export", model, "--to", "fmi2", "--out", tmp_path / "boom.fmu")
    assert code == 0
    assert (tmp_path / "boom.fmu").stat().st_size > 10_000
    code, out, _ = call("verify", model, "--points", 60)
    assert code == 0
    assert re.search(r"^python: boom.p_pump \[bar\] +0 +0 +0 ", out, re.MULTILINE)


@pytest.mark.slow
def test_networks_of_ones_own_drive_the_machine(call):
    page = (Path(__file__).parents[2] / "docs" / "flow_models.md").read_text()
    block = re.search(r"```sh\n(polydraulic sample .*?)```", page, re.DOTALL)[1]
    for line in block.replace("\\\n", " ").splitlines():
        code, out, _ = call(*shlex.split(line)[1:])
        assert code == 0, line
    tip = re.search(r"(?m)^ *tip +(\d\S*) ", out)[1]
    assert float(tip) < 15.0  # mm; the page says what it was
    assert f"within {float(tip):.1f} mm of the exact run in `sine`" in page


def test_fit_needs_no_hydraulics(call, tmp_path):
    x = np.random.default_rng(0).uniform(size=(200, 2))
    np.savetxt(
        tmp_path / "t.csv", np.column_stack([x, x[:, 0] ** 2 + x[:, 1]]), delimiter=",", header="a,b,c", comments=""
    )
    code, out, _ = call("fit", tmp_path / "t.csv", "--inputs", "a,b", "--outputs", "c", "--out", tmp_path / "m.json")
    assert code == 0
    assert float(re.search(r"held-out R2 1 - (\S+),", out)[1]) < 5e-5


def test_check_proves_where_a_model_can_go(call, tmp_path):
    x = np.random.default_rng(0).uniform(-1.0, 1.0, size=(200, 2))
    y = np.where(x[:, 0] > 0.0, 3.0 * x[:, 1], x[:, 0])
    table, model = tmp_path / "t.csv", tmp_path / "m.json"
    np.savetxt(table, np.column_stack([x, y]), delimiter=",", header="a,b,c", comments="")
    code, out, _ = call(
        "fit", table, "--inputs", "a,b", "--outputs", "c", "--out", model, "--regions", 2, "--layers", 1
    )
    assert code == 0
    assert "c: 2 network(s)" in out
    code, out, _ = call("check", model)
    assert code == 0
    assert re.search(r"a in \(0.0\d+, inf\): -2.9\d+ to 2.9\d+, slopes", out)
    assert re.search(r"by b +0 to +(3|3.00\d+)\n", out)  # 0 where b is moved to the border of its data
    code, out, _ = call("check", model, "--range", "-3.01,3.01")
    assert (code, "c cannot leave [-3.01, 3.01]: it is proved to stay in [" in out) == (0, True)
    code, out, _ = call("check", model, "--range", "-1.5,3.01")
    assert (code, "c leaves [-1.5, 3.01]" in out) == (1, True)
    assert call("check", model, "--range", "-1.5,3.01", "--box", "a=-1,-0.5")[0] == 0


def test_check_reads_and_prints_units(call, tmp_path):
    x = np.random.default_rng(0).uniform(0.0, 0.01, size=200)
    write_table(Table({"x": x, "q": 0.2 * x}, {"x": "m", "q": "m3/s"}), tmp_path / "t.parquet")
    model = tmp_path / "m.json"
    code, out, _ = call("fit", tmp_path / "t.parquet", "--inputs", "x", "--outputs", "q", "--out", model)
    assert (code, out.startswith("q [l/min]: 1 network(s)")) == (0, True)
    assert load_models(model)[0].output.unit == "m3/s"
    assert "q [m3/s]: 1 network(s)" in call("fit", tmp_path / "t.parquet", "--inputs", "x", "--outputs", "q",
                                           "--out", model, "--units", "si")[1]  # fmt: skip
    out = call("check", model)[1]
    assert float(re.search(r"q \[l/min\]: proved range \S+ to (\S+)", out)[1]) == pytest.approx(120.0, rel=0.2)
    assert float(re.search(r"by x \[mm\] +\S+ to +(\S+)", out)[1]) == pytest.approx(12.0, rel=0.05)
    same = [call("check", model, "--range", text, "--box", "x=0,5 mm")[1] for text in ("0,0.00105", "0,63 l/min")]
    assert same[0] == same[1]
    assert "q cannot leave [0, 63] l/min: it is proved to stay" in same[0]
    code, _, err = call("check", model, "--range", "0,170 bar")
    assert (code, "--range '0,170 bar': is in 'bar', the column in 'm3/s'; give a unit of that kind" in err) == (
        2,
        True,
    )


def test_fit_reads_edges_and_bounds_with_units(call, tmp_path):
    x = np.linspace(0.0, 0.01, 200)
    write_table(Table({"x": x, "q": np.where(x > 0.004, x, 0.0)}, {"x": "m", "q": "m3/s"}), tmp_path / "t.parquet")
    fitted = ("fit", tmp_path / "t.parquet", "--inputs", "x", "--outputs", "q", "--layers", 1, "--out")
    assert call(*fitted, tmp_path / "si.json", "--edges", "x=0.004", "--bounds", "0, 0.5")[0] == 0
    assert call(*fitted, tmp_path / "units.json", "--edges", "x=4 mm", "--bounds", "0, 30000 l/min")[0] == 0
    si, units = (load_models(tmp_path / name)[0] for name in ("si.json", "units.json"))
    assert si.predict(x[:, None]).tolist() == units.predict(x[:, None]).tolist()
    assert len(units.networks) == 2
    write_table(
        Table({"x": 1e3 * x, "q": np.where(x > 0.004, x, 0.0)}, {"x": "mm", "q": "m3/s"}), tmp_path / "t.parquet"
    )
    assert call(*fitted, tmp_path / "other.json", "--edges", "x=0.4 cm")[0] == 0
    assert load_models(tmp_path / "other.json")[0].partition.at == pytest.approx(4.0)


@pytest.fixture
def files(tmp_path):
    (tmp_path / "good.csv").write_text("a,b,c\n" + "\n".join(f"{i},{i % 3},{i * i}" for i in range(30)))
    (tmp_path / "nan.csv").write_text("a,b,c\n1,2,3\n4,nan,6\n")
    (tmp_path / "flat.csv").write_text("a,b,c\n" + "\n".join(f"{i},5,{i * i}" for i in range(30)))
    (tmp_path / "empty.csv").write_text("a,b,c\n")
    (tmp_path / "large.csv").write_text("a,b,c\n" + "\n".join(f"{i}e306,{i % 3},{i}e200" for i in range(30)))
    (tmp_path / "short.csv").write_text("a,b,c\n1,2,3\n2,3,5\n")
    (tmp_path / "bad.json").write_text("{")
    constant = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0)
    save_models([Model((Variable("a"),), Variable("c"), (constant,))], tmp_path / "c.json")
    (tmp_path / "new.json").write_text('{"format": "polydraulic model", "schema": 99, "models": []}')
    return tmp_path


FIT = ("--inputs", "a,b", "--outputs", "c", "--out", "{0}/m.json")


def test_a_log_becomes_a_model_with_a_card_and_is_judged_by_the_next_one(call, tmp_path):
    for seed, scale in ((1, 1.0), (2, 1.0), (3, 0.8)):
        rng = np.random.default_rng(seed)
        t = 0.01 * np.arange(1000)
        a, b = np.sin(t), np.cos(0.37 * t)
        y = scale * a * b + 0.01 * rng.normal(size=len(t))
        write_table(Table({"time": t, "a": a, "b": b, "y": y}, {"time": "s", "y": "Pa"}), tmp_path / f"{seed}.parquet")
    model, card = tmp_path / "m.json", tmp_path / "m.html"
    code, _, _ = call(
        "fit", tmp_path / "1.parquet", "--inputs", "a,b", "--outputs", "y", "--out", model, "--card", card
    )
    assert code == 0
    assert "blocks of time" in card.read_text()
    code, out, _ = call(
        "fit", tmp_path / "1.parquet", tmp_path / "2.parquet", "--inputs", "a,b", "--outputs", "y", "--out", model
    )
    assert (code, load_models(model)[0].training["rows"]) == (0, 2000)
    code, _, err = call(
        "fit", tmp_path / "1.parquet", tmp_path / "1.parquet", "--inputs", "a,b", "--outputs", "y", "--out", model
    )
    assert (code, "1.parquet (2) has the same rows as 1.parquet (1); give each table once" in err) == (2, True)
    code, out, _ = call("check", model, "--data", tmp_path / "2.parquet")
    assert (code, out.splitlines()[0]) == (0, "y [bar]: holds")
    code, out, _ = call("check", model, "--data", tmp_path / "3.parquet")
    assert (code, out.splitlines()[0]) == (1, "y [bar]: does not hold any more")


def test_regions_from_the_deadbands_that_a_log_shows(call, tmp_path):
    rng = np.random.default_rng(5)
    t = 0.02 * np.arange(6000)
    u = np.sin(0.9 * t) * np.cos(0.13 * t)
    y = np.maximum(u - 0.3, 0.0) - np.maximum(-0.2 - u, 0.0) + 0.002 * rng.normal(size=len(t))
    units = {"time": "s", "segment": "1", "u": "m", "y": "m3/s"}
    log = Table({"time": t, "segment": np.zeros(len(t)), "u": u, "y": y}, units)
    write_table(log, tmp_path / "log.parquet")
    model = tmp_path / "m.json"
    code, out, _ = call(
        "fit", tmp_path / "log.parquet", "--inputs", "u", "--outputs", "y", "--out", model, "--deadbands"
    )
    assert code == 0
    assert "y answers u below" in out
    boxes = load_models(model)[0].region_boxes()
    assert [box[0, 1] for box in boxes[:2]] == pytest.approx([-0.2, 0.3], abs=0.03)
    write_table(Table({"u": u, "y": y}, {}), tmp_path / "rows.parquet")
    code, _, err = call(
        "fit", tmp_path / "rows.parquet", "--inputs", "u", "--outputs", "y", "--out", model, "--deadbands"
    )
    assert (code, "deadbands are found in an imported log" in err) == (2, True)


def test_the_machine_leaves_python(call, tmp_path):
    code, out, _ = call("export-machine", "--to", "c", "--name", "digger", "--out", tmp_path)
    assert code == 0
    assert sorted(path.name for path in tmp_path.glob("digger*.c")) == [
        "digger.c",
        "digger_kernels.c",
        "digger_parameters.c",
    ]
    assert all(str(path) in out for path in tmp_path.iterdir())
    code, out, _ = call("export-machine", "--to", "fmi2", "--out", tmp_path / "m.fmu")
    assert code == 0
    assert out.startswith(f"{tmp_path / 'm.fmu'}: ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("simulate", "single_08", "--flow", "magic"), "unknown flow model 'magic'"),
        (("simulate", "single_08", "--dt", "0"), "dt = 0.0 s"),
        (("simulate", "single_08", "--dt", "20"), "at least one time step"),
        (("simulate", "single_09"), "unknown scenario 'single_09'"),
        (("simulate", "single_08", "--machine", "cat1"), "unknown parameter set 'cat1'"),
        (("machine", "draw", "cat1", "--out", "{0}/m.svg"), "unknown parameter set 'cat1'"),
        (("machine", "draw", "cat215b", "--out", "{0}/m.gif"), "a picture ends in one of ['.svg', '.png', '.pdf']"),
        (("machine", "draw", "cat215b", "--out", "{0}/m.svg", "--units", "imperial"), "units = 'imperial'"),
        (("simulate", "single_08", "--model", "{0}/bad.json"), "--model goes with --flow polynomial, neural"),
        (("simulate", "single_08", "--flow", "polynomial", "--model", "{0}/bad.json"), "bad.json: not a model file"),
        (("simulate", "single_08", "--flow", "polynomial", "--model", "{0}/new.json"), "has schema 99"),
        (("simulate", "task", "--arrangement", "direct"), "--arrangement goes with --flow polynomial"),
        (("simulate", "task", "--flow", "polynomial", "--arrangement", "odd"), "arrangement = 'odd': choose one of"),
        (("simulate", "single_08", "--out", "{0}/run.txt"), "ends in .csv or .parquet"),
        (("simulate", "single_08", "--plot", "{0}/run.gif"), "a picture ends in one of"),
        (("simulate", "single_08", "--out", "{0}/good.csv/run.csv"), "cannot write"),
        (("simulate", "single_08", "--raster", "0.007"), "raster = 0.007 s"),
        (("simulate", "single_08", "--out", "{0}/r.csv", "--plot", "{0}/r.gif"), "a picture ends in one of"),
        (("simulate", "random:x"), "scenario 'random:x': must be random:SEED"),
        (("simulate", "{0}/good.csv"), "good.csv: no column 'swing'"),
        (("animate", "single_08", "--out", "{0}/run.mp4"), "an animation ends in one of"),
        (("animate", "single_08", "--flow", "magic", "--out", "{0}/run.gif"), "unknown flow model 'magic'"),
        (("animate", "single_08", "--rate", "0", "--out", "{0}/run.gif"), "0.0 frames/s over 10 s"),
        (("animate", "single_08", "--out", "{0}/good.csv/run.html"), "cannot write"),
        (("sample", "--rows", "0", "--out", "{0}/s.csv"), "rows = 0"),
        (("sample", "--circuit", "swing", "--rows", "5", "--out", "{0}/s.csv"), "unknown circuit 'swing'"),
        (("fit", "{0}/none.csv", *FIT), "none.csv: no such file"),
        (
            ("fit", "{0}/good.csv", "--inputs", "a", "--outputs", "c", "--out", "{0}/m.txt"),
            "m.txt: a model file ends in .json",
        ),
        (("fit", "{0}/nan.csv", *FIT), "column 'b' holds nan in row 2"),
        (("fit", "{0}/flat.csv", *FIT), "column 'b' is 5 in all 30 rows"),
        (("fit", "{0}/short.csv", *FIT), "the table has 2 rows"),
        (("fit", "{0}/empty.csv", *FIT), "the table has no rows"),
        (("fit", "{0}/large.csv", *FIT), "the values are too large"),
        (("fit", "{0}", *FIT), "a table ends in .csv or .parquet"),
        (("fit", "{0}/good.csv", "--inputs", "a,z", "--outputs", "c", "--out", "{0}/m.json"), "no column 'z'"),
        (("fit", "{0}/good.csv", "--inputs", "a,a", "--outputs", "c", "--out", "{0}/m.json"), "different column names"),
        (("fit", "{0}/good.csv", *FIT, "--layers", "0"), "max_layers = 0"),
        (("fit", "{0}/good.csv", *FIT, "--prior", "guess"), "--prior 'guess'"),
        (("fit", "{0}/good.csv", *FIT, "--bounds", "1"), "--bounds '1'"),
        (("fit", "{0}/good.csv", *FIT, "--edges", "a=x"), "--edges a"),
        (("fit", "{0}/good.csv", *FIT, "--edges", "a=5", "--edges", "a = 9"), "--edges a: is given twice, '5' and '9'"),
        (("fit", "{0}/good.csv", *FIT, "--inputs", "a"), "--inputs 'a,b,a': must be different column names"),
        (("fit", "{0}/good.csv", *FIT, "--bounds", "0,5", "--bounds", "0,9"), "--bounds '0,5,0,9': must be LOW,HIGH"),
        (("check", "{0}/c.json", "--range", "0,5", "--range", "0,9"), "--range '0,5,0,9': must be LOW,HIGH"),
        (("check", "{0}/c.json", "--box", "a=0,5", "--box", "a=0,9"), "--box a: is given twice, '0,5' and '0,9'"),
        (("fit", "{0}/good.csv", *FIT, "--edges", "q=1"), "edges name the column 'q'"),
        (("fit", "{0}/good.csv", *FIT, "--edges", "q=1 mm"), "no column 'q'"),
        (
            ("fit", "{0}/good.csv", *FIT, "--edges", "a=5 mm,10 mm"),
            "--edges a '5 mm,10 mm': must be EDGE,EDGE,..., with a unit behind",
        ),
        (("fit", "{0}/good.csv", *FIT, "--bounds", "1,2 l/min"), "is in 'l/min', the column in ''"),
        (("check", "{0}/bad.json"), "bad.json: not a model file"),
        (("check", "{0}/c.json", "--box", "z=0,1"), "the model of 'c' reads ['a']"),
        (("check", "{0}/c.json", "--box", "a=1"), "--box a"),
        (("check", "{0}/c.json", "--range", "2,1"), "range [2.0, 1.0]"),
        (("export", "{0}/bad.json", "--out", "{0}/c"), "bad.json: not a model file"),
        (("export", "{0}/c.json", "--to", "simulink", "--out", "{0}/c"), "unknown target 'simulink'; choose one of"),
        (("export", "{0}/c.json", "--to", "fmi3", "--out", "{0}/good.csv/c.fmu"), "cannot write"),
        (
            ("export", "{0}/c.json", "--to", "latex", "--real", "float", "--out", "{0}/c"),
            "goes with the targets c and onnx",
        ),
        (("export", "{0}/c.json", "--real", "half", "--out", "{0}/c"), "real = 'half'"),
        (
            ("export-machine", "--to", "onnx", "--out", "{0}/m"),
            "--to 'onnx': the machine can be written as c, fmi2 or fmi3",
        ),
        (("verify", "{0}/bad.json"), "bad.json: not a model file"),
        (("report", "--chapter", "10", "--out", "{0}/r"), "no chapter 10"),
        (("report", "--out", "{0}/good.csv/r"), "cannot write"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(call, files, arguments, message):
    before = sorted(files.iterdir())
    code, _, err = call(*(argument.format(files) for argument in arguments))
    assert code == 2
    assert message in err
    assert "Traceback" not in err
    assert err.strip().splitlines()[-1].startswith("error: ")
    assert sorted(files.iterdir()) == before
