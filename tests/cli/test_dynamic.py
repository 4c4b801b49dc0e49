"""Dynamic models on the command line, from a log to one that is judged by the next one."""

import re

import pytest

from helpers.joint_log import joint_log
from helpers.logs_with_memory import memory_log
from polydraulic import load_models, save_models
from polydraulic.networks import Model, Network, Variable
from polydraulic.tables import Table, read_table, write_table


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, log in {
        "log.parquet": memory_log(), "next.csv": memory_log(seed=1), "worn.csv": memory_log(seed=1, gain=0.2),
        "coarse.csv": memory_log(raster=0.04), "few.csv": memory_log(n=100),
    }.items():  # fmt: skip
        write_table(log, name)
    untimed = memory_log()
    write_table(Table({name: untimed[name] for name in "uyz"}, {}), "untimed.csv")
    constant = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0)
    save_models([Model((Variable("u"),), Variable("y"), (constant,))], "static.json")
    return tmp_path


FIT = "--inputs u --outputs y --dynamic --longest-lag 1 --layers 1 --out m.json"


def test_a_log_becomes_a_model_that_runs_and_is_judged(call, files):
    code, out, _ = call(f"fit log.parquet {FIT} --card m.html")
    assert code == 0
    assert out.startswith("y [bar]\n  4 free runs of up to 29 rows (0.58 s) that were held out: R2 0.99")
    assert re.search(r"reads u [01, ]+; y 1 rows ago", out)
    assert out.endswith("\nm.json: written\nm.html: written\n")
    assert "free run" in (files / "m.html").read_text()
    assert (files / "m.card.json").is_file()
    rms = float(re.search(r"held out: R2 \S+, rms (\S+) bar", out)[1])
    assert load_models("m.json")[0].training["free_run_rms"] == pytest.approx(1e5 * rms, rel=1e-3)

    code, out, _ = call("check m.json --data next.csv")
    assert (code, out.splitlines()[0]) == (0, "y [bar]: holds")
    code, out, _ = call("check m.json --data worn.csv")
    assert (code, out.splitlines()[0]) == (1, "y [bar]: does not hold any more")
    code, _, err = call("check m.json --data coarse.csv")
    assert (code, "are 0.04 s apart, those of the model 0.02 s" in err) == (2, True)
    code, _, err = call("check m.json --data untimed.csv")
    assert (code, "the table has no column 'time'" in err) == (2, True)

    code, out, _ = call("check m.json --data next.csv worn.csv")
    assert (code, out.splitlines()[0]) == (1, "y [bar]: does not hold any more")
    for several in ("--data next.csv log.parquet", "--data next.csv --data log.parquet", "--data n*t.csv log.parquet"):
        code, out, _ = call(f"check m.json {several}")
        assert (code, out.splitlines()[0]) == (0, "y [bar]: holds")
    assert "model is judged by tables that follow --data" in call("check m.json next.csv")[2]
    assert "4 free run(s) of up to 299 rows" in call("run m.json next.csv log.parquet")[1]

    code, out, _ = call("run m.json next.csv --out run.parquet --plot run.svg")
    assert code == 0
    assert out.startswith("2 free run(s) of up to 299 rows, 598 of 600 rows answered\ny, free run: R2 0.99")
    assert read_table("run.parquet").names == ["time", "run", "y", "y.run", "y.one_step"]
    assert (files / "run.svg").read_text().startswith("<?xml")
    assert "20 free run(s) of up to 30 rows" in call("run m.json next.csv --every 0.6")[1]
    for bad, message in {
        "--every 0.001": "no less than the raster of 0.02 s",
        "--every inf": "every = inf s: must be finite",
        "--plot r.gif": "a picture ends in",
        "--out r.txt": "ends in .csv or .parquet",
    }.items():
        code, _, err = call(f"run m.json next.csv {bad}")
        assert (code, message in err) == (2, True)

    code, out, _ = call("check m.json")
    assert code == 0
    assert "note: dynamic, a function of lagged values: u" in out
    assert re.search(r"by y\[t-1\] \[bar\] ", out)
    code, out, _ = call("export m.json --to python --out m.py")
    assert code == 0
    assert "shifts them from row to row, and lets the output change from the last one y by -" in out
    out = call("export m.json --to c --out c")[1]
    assert "gcc -std=c99 -DY_SELF_TEST c/y.c -lm" in out
    assert "gcc -std=c99 -DY_RUN_SELF_TEST c/y.c c/y_run.c -lm" in out
    assert "RUN_SELF_TEST" not in call("export m.json --to c --real float --out single")[1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (f"fit untimed.csv {FIT}", "the table has no column 'time'"),
        (f"fit few.csv {FIT}", "the log has 100 rows; to hold blocks of time out it takes 210"),
        (f"fit log.parquet {FIT} --edges u=0.5", "--edges goes with static models"),
        (f"fit log.parquet {FIT} --regions 3", "--regions goes with static models"),
        (f"fit log.parquet {FIT} --bounds 0,1", "--bounds goes with static models"),
        (f"fit log.parquet {FIT} --deadbands", "--deadbands goes with static models"),
        (f"fit log.parquet {FIT} --card m.pdf", "a model card ends in .html"),
        (f"fit log.parquet {FIT} --prior guess", "--prior 'guess'"),
        (f"fit log.parquet {FIT} --cpm -1", "cpm = -1.0"),
        ("fit log.parquet --inputs u --outputs u --dynamic --out m.json", "column 'u' is both input and output"),
        ("fit log.parquet --inputs u --outputs y --longest-lag 3 --out m.json", "--longest-lag goes with --dynamic"),
        ("run static.json log.parquet", "the model of 'y' is static"),
        ("run none.json log.parquet", "model file none.json: no such file"),
        ("run static.json none.csv", "none.csv: no such file"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(call, files, line, message):
    before = sorted(files.iterdir())
    code, _, err = call(line)
    assert code == 2
    assert message in err
    assert err.strip().splitlines()[-1].startswith("error: ")
    assert sorted(files.iterdir()) == before


def test_help_shows_an_example(call):
    code, out, _ = call("run --help")
    assert code == 0
    assert "Example: polydraulic run" in re.sub(r"\s+", " ", out)
    assert "--dynamic" in call("fit --help")[1]


def test_joints_are_learnt_from_their_commands(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_table(joint_log(n=1500), "log.parquet")
    code, out, _ = call(
        "fit-joints log.parquet --commands lever.a --joints a --more-inputs lever.b --continuous a --horizon 5 --out j.json"
    )
    assert code == 0
    assert "turn without end" in out
    assert "lever.a moves it beyond" in out
    assert out.endswith("\nj.json: written\n")
    assert load_models("j.json")[0].output.name == "a"
    code, _, err = call("fit-joints log.parquet --commands lever.a,lever.b --joints a --out k.json")
    assert (code, "2 commands for 1 joints" in err) == (2, True)
    code, _, err = call("fit-joints log.parquet --commands lever.a --commands lever.b --joints a --out k.json")
    assert (code, "2 commands for 1 joints" in err) == (2, True)


@pytest.mark.parametrize("option", ["--commands", "--joints", "--more-inputs", "--continuous"])
def test_lists_given_twice_add_up(call, option):
    given = {"--commands": "c", "--joints": "j", "--more-inputs": "m", "--continuous": "j"}
    line = " ".join(f"{name} {value}" for name, value in given.items())
    code, _, err = call(f"fit-joints log.parquet {line} {option} {given[option]} --out k.json")
    name = given[option]
    assert (code, f"{option} '{name},{name}': must be different column names" in err) == (2, True)
