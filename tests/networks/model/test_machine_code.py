"""Machine code is kept, found again, and never that of something else."""

import gc
import weakref

import numba
import numpy as np
import pytest

from polydraulic import _kernel_cache
from polydraulic._kernel import driver
from polydraulic.networks import Model, Network, Node, Variable
from polydraulic.networks.model import machine_code
from polydraulic.networks.model.machine_code import NetworkCode, answer_of, network_code

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="machine code is for compiled kernels")


@driver
def answer(code, number, x):
    return answer_of(code, number, x)


def model(factor):
    node = Node(0, (0,), (0.0, float(factor), 0.0, 0.0))
    return Model((Variable("x"),), Variable("y"), (Network((node,), (0.0,), (1.0,), (-10.0,), (10.0,), 0.0, 1.0),))


def asked(factor):
    code = network_code([model(factor)])
    return answer(code, 0, np.array([2.0])) / 2.0


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A place of its own, and nothing in memory, as in a new process."""
    monkeypatch.setattr(machine_code, "cache_folder", lambda: str(tmp_path))
    monkeypatch.setattr(machine_code, "_in_memory", weakref.WeakValueDictionary())
    monkeypatch.setattr(_kernel_cache, "_warned", False)
    return tmp_path / "networks"


@pytest.fixture
def compiled(monkeypatch):
    """Models that are compiled, and not read."""
    found, compiling = [], machine_code._compiled

    def counted(*arguments):
        found.append(arguments)
        return compiling(*arguments)

    monkeypatch.setattr(machine_code, "_compiled", counted)
    return found


def test_code_is_compiled_once_and_read_by_the_next_process(folder, compiled):
    assert asked(3) == 3.0
    gc.collect()
    assert not machine_code._in_memory  # nobody holds it any more
    assert (asked(3), asked(4)) == (3.0, 4.0)
    assert len(compiled) == 2
    assert len([*folder.iterdir()]) == 2


@pytest.mark.parametrize(
    "damage",
    [lambda b: b"", lambda b: b[:20], lambda b: b[: len(b) // 2], lambda b: b"\0" * len(b),
     lambda b: b[:-100] + bytes([b[-100] ^ 1]) + b[-99:], lambda b: b + b"x"],
)  # fmt: skip
def test_a_damaged_file_is_replaced(folder, compiled, damage):
    assert asked(3) == 3.0
    (path,) = folder.iterdir()
    sound = path.read_bytes()
    path.write_bytes(damage(sound))
    assert asked(3) == 3.0
    assert len(compiled) == 2
    assert path.read_bytes() == sound


def test_a_file_of_another_model_is_replaced(folder, compiled):
    assert (asked(3), asked(4)) == (3.0, 4.0)
    (first, second) = folder.iterdir()
    first.write_bytes(second.read_bytes())  # sound, under a name that is not its own
    assert (asked(3), asked(4)) == (3.0, 4.0)
    assert len(compiled) == 3


def test_another_processor_or_version_has_files_of_its_own(folder, compiled, monkeypatch):
    asked(3)
    here = machine_code._target()
    monkeypatch.setattr(machine_code, "_target", lambda: here._replace(features=here.features + ",-avx512f"))
    assert asked(3) == 3.0
    monkeypatch.setattr(machine_code, "_target", lambda: here)
    monkeypatch.setattr(machine_code.llvmlite, "__version__", "0.0")
    assert asked(3) == 3.0
    assert len(compiled) == len([*folder.iterdir()]) == 3


def test_without_a_place_it_is_compiled_in_every_process(tmp_path, compiled, monkeypatch):
    monkeypatch.setattr(machine_code, "cache_folder", lambda: None)
    assert (asked(3), asked(3)) == (3.0, 3.0)
    (tmp_path / "file").touch()
    monkeypatch.setattr(machine_code, "cache_folder", lambda: str(tmp_path / "file"))
    with pytest.warns(RuntimeWarning, match=r"cannot be kept in .*file.*NUMBA_CACHE_DIR") as warned:
        assert (asked(3), asked(4)) == (3.0, 4.0)
    assert len(warned) == 1
    assert len(compiled) == 4


def test_files_that_nobody_has_read_for_longest_go(folder, monkeypatch):
    monkeypatch.setattr(machine_code, "_MOST_KEPT", 3)
    for factor in (1, 2, 3, 1, 4, 5):
        asked(factor)
    assert len([*folder.iterdir()]) == 3


def test_code_lives_as_long_as_its_addresses():
    code = network_code([model(3), model(4)])
    seen = NetworkCode(code.begins[1:], code.constants[1:])
    del code
    gc.collect()
    assert answer(seen, 0, np.array([1.0])) == 4.0
    assert len(machine_code._in_memory) == 2
    del seen
    gc.collect()
    assert not machine_code._in_memory


def test_a_constant_needs_no_code(compiled):
    models = [
        Model((Variable("x"),), Variable("y"), (Network((), (0.0,), (1.0,), (0.0,), (1.0,), 7.0, 1.0, 0.0, high),))
        for high in (10.0, 5.0)
    ]
    code = network_code([models[0], model(3), models[1]])
    assert code.begins.astype(bool).tolist() == [False, True, False]
    assert [answer(code, k, np.array([2.0])) for k in range(3)] == [7.0, 6.0, 5.0]
    assert len(compiled) == 1


def test_the_same_model_is_in_memory_once():
    code = network_code([model(3), model(3), model(4)])
    assert code.begins[0] == code.begins[1] != code.begins[2]


def test_code_that_calls_does_not_know_the_model():
    for factor in (3, 4, 5):
        assert asked(factor) == factor
    assert len(answer.signatures) == 1
