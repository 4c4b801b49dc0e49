"""One record for all exporters."""

from pathlib import Path

import pytest

from polydraulic.export import TARGETS, Exported, export_c, export_fmu, export_machine, export_models
from polydraulic.networks import Dynamics, Lag, Model, Network, Variable


def test_it_iterates_over_its_files_and_lists_them():
    made = Exported((Path("a.h"), Path("a.c")), ("names: b c is b_c",))
    header, source = made
    assert (header, source, len(made)) == (Path("a.h"), Path("a.c"), 2)
    assert made.main == header
    assert str(made) == "a.h\na.c\nnote: names: b c is b_c"
    assert str(Exported((Path("a.fmu"),), binaries=("x86_64-linux",))) == "a.fmu: x86_64-linux"


def test_every_exporter_gives_one(machine, exported_models, tmp_path):
    for to in TARGETS:
        made = export_models(exported_models["several"], to, tmp_path / to)
        assert isinstance(made, Exported)
        assert set(made) == set((tmp_path / to).iterdir())
    made = export_machine(machine, "exact", tmp_path / "machine", name="digger")
    assert isinstance(made, Exported)
    assert made.main.name == "digger.h"
    assert set(made) == set((tmp_path / "machine").iterdir())


def test_what_must_be_known_is_told_by_the_exporter_itself(exported_models, tmp_path):
    assert export_c(exported_models["several"], tmp_path, name="m").notes == ("names: out put is out_put",)
    assert (
        "the FMU holds sources only" in export_fmu(exported_models["single"], tmp_path / "s.fmu", compiler="").notes[0]
    )


@pytest.mark.parametrize("to", TARGETS)
def test_who_shifts_the_lagged_values_of_a_dynamic_model_is_told(to, tmp_path):
    one = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0)
    model = Model((Variable("y[t-1]"),), Variable("y"), (one,), dynamics=Dynamics((Lag("y", 1),), (-1.0, 1.0)))
    made = export_models([model], to, tmp_path)
    told = "dynamic, a function of lagged values: y 1 rows ago. Whoever calls it shifts them"
    if to == "c":  # which runs by itself, and holds the function too
        assert made.notes[-1].startswith("dynamic: y_run.h runs row by row")
    else:
        assert any(note.startswith(told) for note in made.notes)
    if not to.startswith("fmi"):
        text = made.main.read_bytes().decode(errors="replace").replace("\n * ", " ")
        assert told in text  # in the file, too


def test_binaries_are_named(exported_models, tmp_path):
    made = export_fmu(exported_models["single"], tmp_path / "s.fmu", compiler="gcc")
    assert len(made.binaries) == 1
    assert str(made) == f"{tmp_path / 's.fmu'}: {made.binaries[0]}"
