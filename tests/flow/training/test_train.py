"""All files of the whole training, with stand-ins for the searches that take long."""

import pytest

from polydraulic import load_models
from polydraulic.errors import InputError
from polydraulic.flow.training import train
from polydraulic.networks import Model, Network, Variable

CONSTANT = Model((Variable("x"),), Variable("y"), (Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0),))


def test_each_file_is_written_and_told(machine, tmp_path):
    def searched(given, progress):
        assert given is machine
        progress("y", 100, 0.5)
        return [CONSTANT]

    files = {name: (searched if tells else lambda given: [CONSTANT], tells) for name, (_, tells) in train.FILES.items()}
    told = []
    written = train.train_networks(machine, tmp_path / "new", files=files, progress=lambda *piece: told.append(piece))
    assert [path.name for path in written] == [
        "outlets.json", "neural.json", "inlets.json", "cascade.json", "limited.json", "direct.json", "fine.json",
    ]  # fmt: skip
    assert all(load_models(path) == [CONSTANT] for path in written)
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)
    assert told[0] == ("outlets.json", 0, 7)
    assert told[-1] == ("fine.json: y, 100 points", 6, 7)


def test_a_place_that_cannot_be_written_is_named_before_any_search(machine, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file/new: cannot write there"):
        train.train_networks(machine, tmp_path / "file" / "new")
